# The design of these maneuvers is flat around its optimum: rounding keeps the gap just above the default tolerance. A crash stop ends
# at rest, so the maneuvers are arranged in pieces, with the state carried over.
MOMENTS_FLAGS = --instruments nominal
DESIGN_FLAGS = --for iv --criterion d-hessian --tolerance 1e-9 --duration-s 1902 --arrange --vessel $(STUDY)/vessel.toml --dictionary $(STUDY)/dictionary.toml
ESTIMATE_FLAGS = --estimator iv
