# The design of three maneuvers is flat around its optimum: rounding keeps the gap just above the default tolerance.
DESIGN_FLAGS = --tolerance 1e-9
# Within the stated error of its parameters (0.35) some vessels run aground on the plan. It is written all the same, labelled.
PLAN_FLAGS = --allow-unsafe
