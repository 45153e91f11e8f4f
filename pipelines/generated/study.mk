# Predict output-error estimates, make their relative errors small, arrange the maneuvers with the state carried over.
MOMENTS_FLAGS = --campaign $(STUDY)/campaign.toml --estimator output-error
DESIGN_FLAGS = --for output-error --criterion a-relative --relative-to value --starts 0 --tolerance 1e-6 --duration-s 125 --arrange --vessel $(STUDY)/vessel.toml --dictionary $(STUDY)/dictionary.toml
ESTIMATE_FLAGS = --estimator output-error --campaign $(STUDY)/campaign.toml
