# The design of these maneuvers is flat around its optimum: rounding keeps the gap just above the default tolerance. A crash stop ends
# at rest, so the maneuvers are arranged in pieces, with the state carried over.
DESIGN_FLAGS = --tolerance 1e-9 --duration-s 1902 --arrange --vessel $(STUDY)/vessel.toml --dictionary $(STUDY)/dictionary.toml
