# The logs are published in the repository NAOE-5thLab/FRT-DS-ESSO (CC BY-NC-SA): name their folder with LOGS=.
LOGS            ?= ../shared/data/esso_osaka
ESTIMATOR       ?= output-error
# Every resample is fitted anew, a quarter of a second each.
BOOTSTRAP       ?= 100
CROSS_FLAGS     := --window-s 100
# Two of each kind
TEST            ?= random_06-Aug-2020_16_24_25_4,random_31-Jul-2020_14_52_18,turn_14-Oct-2020_14_39_54,turn_14-Sep-2020_13_51_45,zigzag_31-Jul-2020_13_14_21,zigzag_31-Jul-2020_13_50_28
TEST_FLAGS      := --window-s 100
# Six sub-experiments of a minute, at 1 Hz.
DESIGN_FLAGS    := --segments 6 --segment-samples 60
SELECTED        := yes
# The searched model, and half an hour of maneuvers that make it known best.
NEXT            := yes
SEARCH_FLAGS    := --window-s 100 --compact
NEXT_FLAGS      := --duration-s 1800 --tolerance 1e-6
