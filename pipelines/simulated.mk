# Studies on simulated logs: logs.toml and dictionary.toml in $(STUDY) say who sailed what with which instruments, the logs
# go into $(OUT)/logs, and from there on everything is as with measured logs. Included by their study.mk.
#
#   make STUDY=pipelines/model-ship
#   make STUDY=pipelines/model-ship seeds     the selection study on logs of ten other seeds

override LOGS := $(OUT)/logs
# Instruments restart with every sub-experiment; their nominal model is the least-squares fit of the same data, as in the
# paper
MOMENTS_FLAGS ?= --nominal least-squares
SEED_FLAGS    ?=
SELECTION_FLAGS ?= --estimator iv --nominal least-squares --realizations 500
SELECTED := yes
include pipelines/measured.mk

$(LOGS)/simulated.json: $(STUDY)/vessel.toml $(DICTIONARY) $(STUDY)/logs.toml $(BIN)/.built | $(OUT)
	rm -f $(LOGS)/*.csv
	$(BIN)/simulate logs --vessel $(STUDY)/vessel.toml --dictionary $(DICTIONARY) --logs $(STUDY)/logs.toml \
	  $(SEED_FLAGS) $(FLAGS) --out $@

$(MEASURED)/trajectories.parquet: $(LOGS)/simulated.json

# The maneuvers as they are meant, for the report
$(MEASURED)/dictionary.parquet: $(STUDY)/vessel.toml $(DICTIONARY) $(BIN)/.built
	@mkdir -p $(@D)
	$(BIN)/simulate dictionary --vessel $(STUDY)/vessel.toml --dictionary $(DICTIONARY) $(FLAGS) --out $@

$(MEASURED)/report.html: $(STUDY)/reference.toml $(MEASURED)/dictionary.parquet

SEEDS ?= 1 2 3 4 5 6 7 8 9 10

.PHONY: seeds
seeds: $(BIN)/.built
	@mkdir -p $(OUT)/seeds
	@for seed in $(SEEDS); do \
	  $(MAKE) --no-print-directory STUDY=$(STUDY) OUT=$(OUT)/seeds/$$seed SEED_FLAGS="--seed $$seed" FLAGS="$(filter-out --quiet,$(FLAGS)) --quiet" \
	    $(OUT)/seeds/$$seed/measured/selection.parquet > $(OUT)/seeds/$$seed.log 2>&1 || { cat $(OUT)/seeds/$$seed.log; exit 1; }; \
	  echo "seed $$seed: $$(tail -n 1 $(OUT)/seeds/$$seed.log)"; \
	done
