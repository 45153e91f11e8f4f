# The design of three maneuvers is flat around its optimum: rounding keeps the gap just above the default tolerance.
DESIGN_FLAGS = --tolerance 1e-9
