# The pipeline: each stage reads files and writes files; make only names them.
#
#   make                      the paper's simulation study into out/paper/
#   make STUDY=pipelines/my   another study (a folder with vessel.toml, dictionary.toml, campaign.toml)
#   make help                 all targets

# What names of files and folders may be made of: make takes no blanks in them, and a shell reads what else they may hold.
PLAIN := a b c d e f g h i j k l m n o p q r s t u v w x y z A B C D E F G H I J K L M N O P Q R S T U V W X Y Z \
  0 1 2 3 4 5 6 7 8 9 . _ / + -
NAMED := STUDY DICTIONARY OUT LOGS BIN SWEEP SWEEP_OUT PROFILE ROUNDS_DICTIONARY ROUNDS_OUT ESSO_OSAKA_LOGS KVLCC2_LOGS
EMPTY :=
define LINE


endef
# Without the characters of $2; blanks and ends of lines show as [blank]
without = $(if $2,$(call without,$(subst $(firstword $2),,$1),$(wordlist 2,99,$2)),$1)
shown = $(subst $(EMPTY) ,[blank],$(subst $(EMPTY)	,[blank],$(subst $(LINE),[blank],$1)))
check = $(if $(call without,$1,$(PLAIN))$(filter -%,$1),$(error $2: found `$1`, expected a name of letters, digits and . _ / + -, \
  not with a - first; rename the folder or file))
# Those that are given on the command line or by the environment; what they would expand to is not looked at
$(foreach name,$(NAMED),$(if $(filter command environment,$(origin $(name))),$(call check,$(call shown,$(value $(name))),$(name))))

STUDY   ?= pipelines/paper
NAME    := $(notdir $(patsubst %/,%,$(STUDY)))
OUT     ?= out/$(NAME)
CARGO   ?= cargo
# The programs: built for speed; with BIN=target/debug those that `cargo test` builds anyway, which give the same bytes
BIN     ?= target/release
# Flags for every stage, such as FLAGS="--threads 1 --quiet"
FLAGS   ?=
# The stage that a study ends with, after those that it needs; none: its report
STAGE   ?=

STAGES  := simulate moments design estimate validate plan
BINARIES := $(addprefix $(BIN)/,$(STAGES) seatrial)

# A target is written whole or not at all by its stage, so an interrupted make resumes with the next stage.
.DELETE_ON_ERROR:
.SUFFIXES:

# What was set for a stage before study.toml
GONE := MOMENTS_FLAGS DESIGN_FLAGS ESTIMATE_FLAGS PLAN_FLAGS MONTE_CARLO LENGTH_M POOL_FLAGS ESTIMATOR BOOTSTRAP CROSS_FLAGS TEST \
  TEST_FLAGS SELECTION_FLAGS SELECTED NEXT SEARCH_FLAGS NEXT_FLAGS
$(foreach name,$(GONE),$(if $(filter command,$(origin $(name))),$(error $(name): found it on the command line of make, expected keys of \
  study.toml; write FLAGS="--set study.design.segments=5" for `segments = 5` in its table [design])))

# All stages of a study that are not up to date. `seatrial run` knows them.
RUN     = $(strip $(BIN)/seatrial run $(STUDY) $(if $(LOGS),--logs $(LOGS)) $(FLAGS) $(if $(STAGE),--stage $(STAGE)))
RESULTS = $(OUT)$(if $(wildcard $(STUDY)/ingest.toml),/measured)

# Said before anything is built
ifneq ($(filter study,$(or $(MAKECMDGOALS),study)),)
  $(foreach folder,$(STUDY) $(LOGS),$(if $(wildcard $(folder)/.),,$(error $(folder): found no such folder, expected one of a study or of \
    its logs; name it: make STUDY=<folder> LOGS=<folder>)))
endif

.PHONY: study
study: build
	$(RUN) --out $(OUT)
	@$(if $(STAGE),,echo; echo "Report: $(RESULTS)/report.html")

.PHONY: help
help:
	@echo "make                   build, run the study in $(STUDY) into $(OUT)/, end with its report"
	@echo "make STUDY=<folder>    run another study: a folder with vessel.toml, dictionary.toml, campaign.toml; with STAGE=design up to there"
	@echo "make helsinki          plan a trial off Helsinki and draw it, into out/helsinki/"
	@echo "make STUDY=pipelines/esso-osaka LOGS=<folder>   a study of measured logs (docs/own-logs.md: where they are published)"
	@echo "make sequential        trials designed in rounds against trials designed once, into out/sequential/; with STUDY=<folder> of that study"
	@echo "make sweep             a study over a grid of its values (SWEEP=...) into out/sweep/sweep.csv, on a cluster with PROFILE=slurm (needs Python)"
	@echo "make scenarios         compare the estimators under four kinds of disturbance, into out/scenarios/"
	@echo "make results           run all studies, write docs/results.md and the front page's table and picture (takes a while)"
	@echo "make smoke             the small study that the tests run, into out/smoke/"
	@echo "make build             build the stages into $(BIN)/"
	@echo "make test              format, clippy, all tests, the smoke study, the commands of the README and the tutorial"
	@echo "make book              make the book of docs/ as web pages, into out/book/html/ (needs mdBook and Python)"
	@echo "make nightly           make test, and what takes hours: many more damaged inputs, the release build, a sweep on Slurm"
	@echo "make bench             measure against numba, scipy and pyarrow (needs Python; says how to get it)"
	@echo "make faults CASES=...  damage inputs and kill runs, so many times, and say what came of it"
	@echo "make verify            check that the files of the study in $(OUT)/ are whole and belong together"
	@echo "make oracle            compute the oracle fixtures again (needs Python with numpy, scipy, pyarrow)"
	@echo "make python-check      build the wheel for Python and try it, with its notebook (needs the network)"
	@echo "make schemas           write the JSON Schemas of all documents again, and the classes of Python"
	@echo "make golden            write the golden results and schema samples again"
	@echo "make clean             remove out/"

# --- build: cargo decides what is out of date

.PHONY: build
build: $(BINARIES)

SOURCES := Cargo.toml Cargo.lock $(shell find crates -name '*.rs' -o -name 'Cargo.toml' -o -name '*.css' -o -name '*.js' -o -path '*/presets/*' -o -path '*/templates/*')

# Not the examples that no test runs: clippy checks them
TESTS := $(CARGO) test --workspace --locked --tests
BUILD := $(if $(filter target/debug,$(BIN)),$(TESTS) --no-run,$(CARGO) build --release --locked -p seatrial-cli)

$(BIN)/.built: $(SOURCES)
	$(BUILD)
	@touch $@

$(BINARIES): $(BIN)/.built ;

# What writes tables and pictures of this repository's studies
$(BIN)/examples/pages: $(BIN)/.built
	$(CARGO) build --locked --workspace --example pages $(if $(filter target/release,$(BIN)),--release)
	@touch $@

# --- studies

.PHONY: helsinki
helsinki:
	$(MAKE) STUDY=pipelines/helsinki OUT=out/helsinki study

# The selection study of a study on simulated logs, on logs of ten other seeds
SEEDS ?= 1 2 3 4 5 6 7 8 9 10

.PHONY: seeds
seeds: build
	@for seed in $(SEEDS); do \
	  $(RUN) --stage selection --set logs.seed=$$seed --quiet --out $(OUT)/seeds/$$seed || exit 1; done

# Every estimator under four kinds of disturbance, and one page that puts them side by side.
SCENARIOS := white current-constant current-gauss-markov wind-bias
SCENARIO_STUDIES ?= pipelines/scenarios
SCENARIO_OUT     ?= out/scenarios

.PHONY: scenarios
scenarios: build
	@for name in $(SCENARIOS); do \
	  $(MAKE) --no-print-directory STUDY=$(SCENARIO_STUDIES)/$$name OUT=$(SCENARIO_OUT)/$$name study || exit 1; done
	@$(MAKE) --no-print-directory unknown
	$(BIN)/seatrial report --study $(SCENARIO_STUDIES)/white --dictionary pipelines/scenarios/dictionary.toml \
	  --results $(SCENARIO_OUT)/white --scenarios $(SCENARIOS:%=$(SCENARIO_OUT)/%) $(FLAGS) --out $(SCENARIO_OUT)/report.html
	@echo
	@echo "Report: $(SCENARIO_OUT)/report.html"

# The same trials, estimated with what the study does not tell: a current as an unknown, no forces that stay, the noise.
WAYS := current current-alone no-intercepts undeclared
WAY_current       := --estimator output-error --unknown-current earth
WAY_current-alone := $(WAY_current) --intercepts none
WAY_no-intercepts := --estimator output-error --intercepts none
WAY_undeclared    := --estimator prediction-error
UNKNOWN := $(foreach name,$(SCENARIOS),$(WAYS:%=$(SCENARIO_OUT)/$(name)/unknown/%))

.PHONY: unknown
unknown: $(UNKNOWN:%=%/scores.parquet)

# Of the stem white/unknown/current, the first word is the scenario's name and the last the way's
.SECONDEXPANSION:
$(UNKNOWN:%=%/scores.parquet): $(SCENARIO_OUT)/%/scores.parquet: $(SCENARIO_OUT)/$$(*D:/unknown=)/campaign.parquet $(BIN)/seatrial
	@mkdir -p $(@D)
	$(BIN)/seatrial estimate --vessel $(SCENARIO_STUDIES)/$(*D:/unknown=)/vessel.toml --trajectories $< $(WAY_$(*F)) $(FLAGS) \
	  --out $(@D)/estimates.parquet
	$(BIN)/seatrial validate --vessel $(SCENARIO_STUDIES)/$(*D:/unknown=)/vessel.toml --campaign $(SCENARIO_STUDIES)/$(*D:/unknown=)/campaign.toml \
	  --estimates $(@D)/estimates.parquet --validation $(<D)/validation.parquet $(FLAGS) --out $@

# Trials designed in rounds against trials designed once: of the study that is named, or else of pipelines/sequential.
IS_NAMED          := $(filter command environment,$(origin STUDY))
ROUNDS            := $(if $(IS_NAMED),$(STUDY),pipelines/sequential)
ROUNDS_DICTIONARY ?= $(or $(DICTIONARY),$(ROUNDS)/dictionary.toml)
ROUNDS_OUT        ?= $(if $(IS_NAMED),$(OUT)/sequential,out/sequential)
# Such as ROUNDS_FLAGS="--set campaign.rounds.realizations=10000", which docs/results.md tells of
ROUNDS_FLAGS      ?=

.PHONY: sequential
sequential: $(ROUNDS_OUT)/report.html
	@echo
	@echo "Report: $(ROUNDS_OUT)/report.html"

$(ROUNDS_OUT)/scores.parquet: $(ROUNDS)/vessel.toml $(ROUNDS_DICTIONARY) $(ROUNDS)/campaign.toml $(BIN)/seatrial
	@mkdir -p $(@D)
	$(BIN)/seatrial monte-carlo --vessel $(ROUNDS)/vessel.toml --dictionary $(ROUNDS_DICTIONARY) \
	  --campaign $(ROUNDS)/campaign.toml $(ROUNDS_FLAGS) $(FLAGS) --out $@

$(ROUNDS_OUT)/report.html: $(ROUNDS_OUT)/scores.parquet $(BIN)/seatrial
	$(BIN)/seatrial report --study $(ROUNDS) --dictionary $(ROUNDS_DICTIONARY) --results $(ROUNDS_OUT) $(FLAGS) --out $@

# A study over a grid of its values, on Snakemake: on this machine, or on a cluster with PROFILE=slurm. What is there already is
# not made again.
SWEEP       ?= pipelines/sweep/config.yaml
SWEEP_OUT   ?= out/sweep
SWEEP_FLAGS ?=
PROFILE     ?= local

.PHONY: sweep
sweep: build
	@sh pipelines/sweep/run.sh $(SWEEP) $(SWEEP_OUT) $(PROFILE) $(BIN) $(SWEEP_FLAGS)

# Every study that docs/results.md has a table of, then that page, the front page's table and its picture. Takes a while.
# Measured logs take part where their folders are.
ESSO_OSAKA_LOGS ?= ../shared/data/esso_osaka
KVLCC2_LOGS     ?= ../shared/data/kvlcc2_hsva
LOGGED_STUDIES   = $(if $(wildcard $(ESSO_OSAKA_LOGS)/.),esso-osaka) $(if $(wildcard $(KVLCC2_LOGS)/.),kvlcc2)
SELECTED_STUDIES := model-ship full-scale
ELEVEN           := out/sequential-eleven

.PHONY: results
results: build
	$(MAKE) study
	$(MAKE) helsinki
	$(MAKE) STUDY=pipelines/helsinki OUT=out/trials/helsinki STAGE=monte-carlo \
	  FLAGS="--set study.monte_carlo.realizations=10000 --set study.monte_carlo.estimator=iv" study
	$(MAKE) STUDY=pipelines/generated study
	$(MAKE) scenarios
	$(MAKE) ROUNDS_FLAGS="--set campaign.rounds.realizations=10000" sequential
	$(MAKE) ROUNDS_FLAGS="--set campaign.rounds.realizations=10000" ROUNDS_DICTIONARY=pipelines/scenarios/dictionary.toml \
	  ROUNDS_OUT=$(ELEVEN) sequential
	for name in $(SELECTED_STUDIES); do $(MAKE) STUDY=pipelines/$$name OUT=out/$$name seeds || exit 1; done
	for name in $(LOGGED_STUDIES); do \
	  case $$name in esso-osaka) logs="$(ESSO_OSAKA_LOGS)" ;; *) logs="$(KVLCC2_LOGS)" ;; esac; \
	  $(MAKE) STUDY=pipelines/$$name OUT=out/$$name LOGS="$$logs" STAGE=estimate study || exit 1; done
	$(MAKE) docs

.PHONY: docs
docs: $(BIN)/examples/pages
	$(BIN)/examples/pages results --written pipelines --studies out/paper out/generated out/trials/helsinki out/helsinki/planned \
	  --scenarios $(SCENARIOS:%=$(SCENARIO_OUT)/%) --unknown $(UNKNOWN) --rounds out/sequential $(ELEVEN) \
	  --selections $(foreach name,$(SELECTED_STUDIES),$(foreach seed,1 2 3 4 5 6 7 8 9 10,out/$(name)/seeds/$(seed)/measured)) \
	  --logs out/esso-osaka/measured out/kvlcc2/measured --out docs/results.md
	sh scripts/front-table.sh docs/results.md README.md
	sh scripts/results-check.sh $(BIN) --write
	$(BIN)/examples/pages picture --plan out/helsinki --study out/paper --out docs/trial.svg
	$(MAKE) --no-print-directory STUDY=pipelines/coaster OUT=out/coaster study
	$(BIN)/examples/pages tracks --merit out/coaster/merit.json --out docs/trials.svg

.PHONY: smoke
smoke:
	$(MAKE) STUDY=pipelines/smoke OUT=out/smoke study

# --- checks

# The small study and the README's commands run the programs that the unit tests have just run: nothing is compiled twice.
.PHONY: test
test: format-check clippy unit
	$(MAKE) BIN=target/debug surface-check smoke readme-check page-check
	$(MAKE) -j2 BIN=target/debug book-check results-check

.PHONY: format-check
format-check:
	$(CARGO) fmt --all --check

.PHONY: clippy
clippy:
	$(CARGO) clippy --workspace --all-targets --locked -- -D warnings

.PHONY: unit
unit:
	$(TESTS)
	$(CARGO) test --workspace --locked --doc

.PHONY: readme-check
readme-check: build $(BIN)/examples/pages
	sh scripts/readme-check.sh $(BIN)

# The tutorial's commands, in a folder without this repository, and the numbers that it states
.PHONY: book-check
book-check: build
	sh scripts/book-check.sh $(BIN)

# Would today's programs write other rows into docs/results.md? Few realizations of each study say it.
.PHONY: results-check
results-check: build $(BIN)/examples/pages
	sh scripts/results-check.sh $(BIN)

# Is there more to know than before? Commands and flags are those of the programs that are built.
.PHONY: surface-check
surface-check: build
	BIN=$(BIN) sh scripts/surface.sh

# The pages of the small study and of the paper's in a browser; skipped where there is no Chromium
.PHONY: page-check
page-check: smoke readme-check
	sh scripts/page-check.sh out/smoke out/paper

# A small sweep with a full disk and a killed master; skipped where there is no Python
.PHONY: sweep-check
sweep-check: build
	bash scripts/sweep-check.sh $(BIN)

# What is too long for every change: tests that say so, the main jobs by the release build, twenty thousand damaged inputs, a thousand faults of
# every kind in logs, and the sweep on a Slurm that is started for it (Debian: slurmctld slurmd slurm-client munge)
.PHONY: nightly
nightly: test
	$(MAKE) BIN=target/release study helsinki results-check
	sh scripts/page-check.sh out/helsinki
	$(MAKE) BIN=target/debug sweep-check
	bash scripts/sweep-check.sh target/release slurm
	$(MAKE) faults CASES=20000
	$(CARGO) test --workspace --locked --tests -- --ignored --skip write
	SEATRIAL_CASES=1000 $(CARGO) test --workspace --locked --test ingest silent

# --- upkeep

.PHONY: bench
bench:
	$(CARGO) build --release --locked -p seatrial-cli --example bench
	@if command -v $(PYTHON) > /dev/null; then $(PYTHON) scripts/bench.py; \
	else echo "no $(PYTHON): our own figures only; for the peers install Python 3.11 and scripts/README.md's packages"; $(BIN)/examples/bench; fi

PYTHON ?= $(if $(wildcard .venv/bin/python),.venv/bin/python,python3)

# Its reference is made of the programs' --help and of schemas/, its figures of the tutorial's study
.PHONY: book
book: book-check
	@if ! command -v mdbook > /dev/null; then echo "no book: found no mdbook; cargo install mdbook --locked gets it"; \
	elif ! command -v $(PYTHON) > /dev/null; then echo "no book: found no $(PYTHON), expected Python 3.11"; \
	else $(PYTHON) scripts/book.py --bin $(BIN) --figures out/book-check/out/tutorial/results/figures --out out/book; fi

# The wheel for Python, its tests and its notebook; needs the network. PYTHON_CHECK=--debug builds without optimization
PYTHON_CHECK ?=
.PHONY: python-check
python-check:
	PYTHON=$(PYTHON) sh scripts/python-check.sh $(PYTHON_CHECK)

.PHONY: faults
# How many inputs are damaged; a tenth of it is how many runs are killed or fail, at least once at every place of every stage
CASES ?= 2000
faults:
	SEATRIAL_CASES=$(CASES) $(CARGO) test --workspace --locked --test faults -- --test-threads=1 --nocapture law_

.PHONY: verify
verify: build
	$(BIN)/seatrial verify $(OUT) --study $(STUDY)

.PHONY: oracle
oracle:
	$(PYTHON) scripts/oracle.py --study pipelines/paper --fixtures fixtures/oracle
	$(PYTHON) scripts/paper_reading.py oracle --out fixtures/oracle/reading.json
	$(PYTHON) scripts/independent/covariances.py --study pipelines/paper --out fixtures/oracle/covariances.json
	$(PYTHON) scripts/independent/rates.py --study pipelines/paper --out fixtures/oracle/rates.json
	$(PYTHON) scripts/independent/pooled.py --out fixtures/oracle/pooled.json
	$(PYTHON) scripts/independent/intervals.py --out fixtures/oracle/intervals.json
	$(PYTHON) scripts/independent/correlations.py --out fixtures/oracle/correlations.json
	$(PYTHON) scripts/independent/average.py --out fixtures/oracle/average.json
	$(PYTHON) scripts/independent/derived.py --out fixtures/oracle/derived.json
	$(PYTHON) scripts/independent/standard_maneuvers.py --out fixtures/oracle/standard_maneuvers.json
	$(PYTHON) scripts/independent/reference_ships.py --out fixtures/oracle/reference_ships.json
	$(PYTHON) scripts/independent/criteria.py --study pipelines/paper --fixtures fixtures/oracle
	$(PYTHON) scripts/independent/chain.py --oracle fixtures/oracle
	$(PYTHON) scripts/independent/output_error.py --study pipelines/paper --fixtures fixtures/oracle
	$(PYTHON) scripts/independent/output_information.py --study pipelines/paper --fixtures fixtures/oracle

.PHONY: schemas
schemas:
	$(CARGO) run --locked -p seatrial-cli --example write_schemas -- schemas
	@if command -v $(PYTHON) > /dev/null; then $(PYTHON) scripts/python_documents.py; \
	else echo "no $(PYTHON): python/src/seatrial/documents.py is not written again"; fi

.PHONY: golden
golden:
	$(CARGO) test --locked -p seatrial-cli --test study --test pooled -- --ignored

.PHONY: clean
clean:
	rm -rf out
