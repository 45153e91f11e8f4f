# The logs are published in the repository NAOE-5thLab/FRT-DS-ESSO (CC BY-NC-SA): name their folder with LOGS=.
LOGS            ?= ../shared/data/esso_osaka
ESTIMATOR       ?= output-error
# Every resample is fitted anew, a quarter of a second each.
BOOTSTRAP       ?= 100
CROSS_FLAGS     := --window-s 100
# Six sub-experiments of a minute, at 1 Hz.
DESIGN_FLAGS    := --segments 6 --segment-samples 60
SELECTED        := yes
include pipelines/measured.mk
