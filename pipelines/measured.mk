# Studies on measured logs: ingest.toml and vessel.toml in $(STUDY), the logs in $(LOGS). Included by their study.mk.
#
#   make STUDY=pipelines/esso-osaka LOGS=<folder with the published logs>
#
# Ends with $(OUT)/measured/report.html. With SELECTED := yes sub-experiments are designed, picked and compared too.

# Where the logs are
LOGS            ?= logs
# Instruments restart with every sub-experiment; their nominal model is the least-squares fit of the same data
POOL_FLAGS      ?= --nominal least-squares
ESTIMATOR       ?= auto
BOOTSTRAP       ?= 1000
CROSS_FLAGS     ?=
# Recordings that a second model is not fitted to and is then tried on (names with commas between); none: no such test
TEST            ?=
TEST_FLAGS      ?=
MOMENTS_FLAGS   ?= --instruments regressors
SELECTION_FLAGS ?= --estimator iv --nominal least-squares
SELECTED        ?=
# With NEXT := yes a structure is searched for, and the next trial of its model is designed: $(STUDY)/next says what the helmsman
# may be asked for, and how long and in which noise the trial is
NEXT            ?=
SEARCH_FLAGS    ?=
NEXT_FLAGS      ?=

MEASURED := $(OUT)/measured
LOGGED   := --vessel $(STUDY)/vessel.toml --trajectories $(MEASURED)/trajectories.parquet
RECORDED := --recordings $(MEASURED)/ingest.json
NEXT_TRIAL := $(MEASURED)/next
NEXT_MODEL := --vessel $(NEXT_TRIAL)/model.json
NEXT_SEA   := --campaign $(STUDY)/next/campaign.toml
NO_LOGS   = $(LOGS): no such folder; name that of the logs: make STUDY=$(STUDY) LOGS=<folder> (docs/own-logs.md: where they are published)

.DEFAULT_GOAL := measured

# Said before anything is built; logs in $(OUT) are made by the study itself.
ifneq ($(filter measured,$(or $(MAKECMDGOALS),measured)),)
  ifeq ($(filter $(OUT)/%,$(LOGS))$(wildcard $(LOGS)/.),)
    $(error $(NO_LOGS))
  endif
endif

.PHONY: measured
measured: $(MEASURED)/report.html
	@echo
	@echo "Report: $(MEASURED)/report.html"

$(MEASURED)/trajectories.parquet: $(STUDY)/ingest.toml $(STUDY)/vessel.toml $(BIN)/.built
	@mkdir -p $(@D)
	$(BIN)/ingest --config $(STUDY)/ingest.toml --vessel $(STUDY)/vessel.toml --logs "$(LOGS)" $(FLAGS) --out $@

$(MEASURED)/estimates.parquet: $(MEASURED)/trajectories.parquet $(wildcard $(STUDY)/study.mk)
	$(BIN)/estimate pool $(LOGGED) $(RECORDED) --estimator $(ESTIMATOR) $(POOL_FLAGS) --bootstrap $(BOOTSTRAP) $(FLAGS) --out $@

$(MEASURED)/crossval.json: $(MEASURED)/trajectories.parquet $(wildcard $(STUDY)/study.mk)
	$(BIN)/validate cross $(LOGGED) $(RECORDED) $(POOL_FLAGS) $(CROSS_FLAGS) $(FLAGS) --out $@

# Fitted to the others, tried on those of TEST
$(MEASURED)/test/estimates.parquet: $(MEASURED)/trajectories.parquet $(wildcard $(STUDY)/study.mk)
	@mkdir -p $(@D)
	$(BIN)/estimate pool $(LOGGED) $(RECORDED) --leave-out "$(TEST)" --estimator $(ESTIMATOR) $(POOL_FLAGS) $(FLAGS) --out $@

$(MEASURED)/compare.json: $(MEASURED)/test/estimates.parquet
	$(BIN)/validate compare --model $(MEASURED)/test/model.json --trajectories $(MEASURED)/trajectories.parquet $(RECORDED) \
	  --runs "$(TEST)" $(TEST_FLAGS) $(FLAGS) --out $@

$(MEASURED)/moments.json: $(MEASURED)/trajectories.parquet $(wildcard $(STUDY)/study.mk)
	$(BIN)/moments $(LOGGED) $(MOMENTS_FLAGS) $(FLAGS) --out $@

# No more of a maneuver than was logged, unless the study says what is available.
WITHIN = $(if $(findstring --available,$(DESIGN_FLAGS)),,--available $(MEASURED)/ingest.json)

$(MEASURED)/design.json: $(MEASURED)/moments.json
	$(BIN)/design --moments $< $(WITHIN) $(DESIGN_FLAGS) $(FLAGS) --out $@

# Published results, where the study has some to compare with
PUBLISHED = $(wildcard $(STUDY)/reference.toml)

$(MEASURED)/selection.parquet: $(MEASURED)/trajectories.parquet $(MEASURED)/design.json $(PUBLISHED)
	$(BIN)/validate selection $(LOGGED) --design $(MEASURED)/design.json $(addprefix --reference ,$(PUBLISHED)) $(SELECTION_FLAGS) $(FLAGS) --out $@

# The model that the next trial is designed with: search.json and model.json
$(NEXT_TRIAL)/search.json: $(MEASURED)/trajectories.parquet $(wildcard $(STUDY)/study.mk)
	@mkdir -p $(@D)
	$(BIN)/estimate search $(LOGGED) $(RECORDED) $(SEARCH_FLAGS) $(FLAGS) --out $@

$(NEXT_TRIAL)/dictionary.parquet: $(NEXT_TRIAL)/search.json $(STUDY)/next/dictionary.toml
	$(BIN)/simulate dictionary $(NEXT_MODEL) --dictionary $(STUDY)/next/dictionary.toml $(FLAGS) --out $@

$(NEXT_TRIAL)/moments.json: $(NEXT_TRIAL)/dictionary.parquet $(STUDY)/next/campaign.toml
	$(BIN)/moments $(NEXT_MODEL) --trajectories $< $(NEXT_SEA) --estimator output-error --hold-unexcited $(FLAGS) --out $@

$(NEXT_TRIAL)/design.json: $(NEXT_TRIAL)/moments.json $(wildcard $(STUDY)/study.mk)
	$(BIN)/design --moments $< --for output-error $(NEXT_FLAGS) $(FLAGS) --out $@

# What the errors of its estimates do to free simulations
$(NEXT_TRIAL)/tally.json: $(NEXT_TRIAL)/design.json
	$(BIN)/monte-carlo $(NEXT_MODEL) --dictionary $(STUDY)/next/dictionary.toml $(NEXT_SEA) --design $< --estimator output-error $(FLAGS) --out $@

# Where it is sailed, where the study says so
NEXT_PLAN = $(if $(wildcard $(STUDY)/next/plan.toml),$(NEXT_TRIAL)/plan.json)

$(NEXT_TRIAL)/plan.json: $(NEXT_TRIAL)/design.json $(STUDY)/next/plan.toml
	$(BIN)/plan $(NEXT_MODEL) --trajectories $(NEXT_TRIAL)/dictionary.parquet --dictionary $(STUDY)/next/dictionary.toml --design $< --config $(STUDY)/next/plan.toml $(FLAGS) --out $@

$(MEASURED)/report.html: $(if $(NEXT),$(NEXT_TRIAL)/tally.json $(NEXT_PLAN))
$(MEASURED)/report.html: $(MEASURED)/estimates.parquet $(MEASURED)/crossval.json $(if $(SELECTED),$(MEASURED)/selection.parquet) $(if $(TEST),$(MEASURED)/compare.json) $(BIN)/.built
	$(BIN)/report --study $(STUDY) --results $(MEASURED) $(FLAGS) --out $@
