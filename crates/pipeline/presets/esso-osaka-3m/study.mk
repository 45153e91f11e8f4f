# Flags of the stages. `seatrial run` reads this file, and make does where the repository is at hand.
# A ship with forces is estimated by output error, from the noise that campaign.toml states. Priors count once for a trial of
# --duration-s.
MOMENTS_FLAGS = --campaign $(STUDY)/campaign.toml --estimator output-error
DESIGN_FLAGS = --for output-error --duration-s 900
ESTIMATE_FLAGS = --estimator output-error --campaign $(STUDY)/campaign.toml
# Length between perpendiculars [m], for the figures of merit.
LENGTH_M = 3
