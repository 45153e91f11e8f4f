# The logs are those of SIMMAN 2008 (HSVA), converted to CSV: name their folder with LOGS=.
LOGS       ?= ../shared/data/kvlcc2_hsva
ESTIMATOR  ?= output-error
BOOTSTRAP  ?= 200
# Recordings of 66 to 210 s in pieces of at most 100 s. The propeller's speed is constant: `iv` refuses surge.
POOL_FLAGS := --nominal least-squares --part-s 100
TEST       ?= kvlcc2_hsva_Z_10_05,kvlcc2_hsva_Z_20_10_S,kvlcc2_hsva_Z_35_05
# The searched model, and half an hour of maneuvers that make it known best. Its parameters can hardly be told apart (condition of
# the information in correlations 4e8): rounding leaves the optimum known to some 1e-5.
NEXT         := yes
SEARCH_FLAGS := --window-s 100 --compact
NEXT_FLAGS   := --duration-s 1800 --tolerance 1e-4
