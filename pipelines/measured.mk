# Studies on measured logs: ingest.toml and vessel.toml in $(STUDY), the logs in $(LOGS). Included by their study.mk.
#
#   make STUDY=pipelines/esso-osaka LOGS=<folder with the published logs>
#
# A study without design and selection (one recording per maneuver) ends with crossval.json, others with a report.

# Where the logs are
LOGS            ?= logs
# Instruments restart with every sub-experiment; their nominal model is the least-squares fit of the same data
POOL_FLAGS      ?= --nominal least-squares
ESTIMATOR       ?= auto
BOOTSTRAP       ?= 1000
CROSS_FLAGS     ?=
MOMENTS_FLAGS   ?= --instruments regressors
SELECTION_FLAGS ?=
# Report that the study ends with, if it has a selection study
SELECTED        ?=

MEASURED := $(OUT)/measured
LOGGED   := --vessel $(STUDY)/vessel.toml --trajectories $(MEASURED)/trajectories.parquet
RECORDED := --recordings $(MEASURED)/ingest.json

.DEFAULT_GOAL := measured

.PHONY: measured
measured: $(MEASURED)/estimates.parquet $(MEASURED)/crossval.json $(if $(SELECTED),$(MEASURED)/report.html)

$(MEASURED)/trajectories.parquet: $(STUDY)/ingest.toml $(STUDY)/vessel.toml $(BIN)/.built
	@mkdir -p $(@D)
	@test -d "$(LOGS)" || { echo "$(LOGS): no such folder; name that of the logs: make STUDY=$(STUDY) LOGS=<folder>" >&2; exit 2; }
	$(BIN)/ingest --config $(STUDY)/ingest.toml --vessel $(STUDY)/vessel.toml --logs "$(LOGS)" $(FLAGS) --out $@

$(MEASURED)/estimates.parquet: $(MEASURED)/trajectories.parquet $(STUDY)/study.mk
	$(BIN)/estimate --pool $(LOGGED) $(RECORDED) --estimator $(ESTIMATOR) $(POOL_FLAGS) --bootstrap $(BOOTSTRAP) $(FLAGS) --out $@

$(MEASURED)/crossval.json: $(MEASURED)/trajectories.parquet $(STUDY)/study.mk
	$(BIN)/validate cross $(LOGGED) $(RECORDED) $(POOL_FLAGS) $(CROSS_FLAGS) $(FLAGS) --out $@

$(MEASURED)/moments.json: $(MEASURED)/trajectories.parquet $(STUDY)/study.mk
	$(BIN)/moments $(LOGGED) $(MOMENTS_FLAGS) $(FLAGS) --out $@

$(MEASURED)/design.json: $(MEASURED)/moments.json
	$(BIN)/design --moments $< $(DESIGN_FLAGS) $(FLAGS) --out $@

$(MEASURED)/selection.parquet: $(MEASURED)/trajectories.parquet $(MEASURED)/design.json
	$(BIN)/validate selection $(LOGGED) --design $(MEASURED)/design.json $(SELECTION_FLAGS) $(FLAGS) --out $@

$(MEASURED)/report.html: $(MEASURED)/selection.parquet
	$(BIN)/report --study $(STUDY) --results $(MEASURED) $(FLAGS) --out $@
