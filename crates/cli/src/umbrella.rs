//! `seatrial`: every stage as a subcommand, with completions and manual pages.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::builder::{PossibleValue, PossibleValuesParser};
use clap::{Arg, ArgMatches, Command, CommandFactory, FromArgMatches, Parser, ValueEnum, value_parser};
use clap_complete::Shell;
use clap_mangen::Man;
use files::{Digest, Error, Provenance, Staged, Trace, check_within, commit, refuse_device, traced};
use refusal::Invalid;
use serde_json::json;
use study::folder::Folder;

use crate::cli::{Common, folder_of, set_budget};
use crate::commands::STAGES;
use crate::failure::{Failure, on_stderr, on_stdout, printed};
use crate::pipeline::{Folders, Pipeline, RunRecord, StudySettings, StudyStep, settings};
use crate::ships;
use crate::stage::{Stage, Summary, Task, dressed, ended, matches, misused};

/// The program `seatrial`.
pub fn main() -> ExitCode {
    let mut command = command();
    let matches = match matches(&mut command, std::env::args_os()) {
        Ok(matches) => matches,
        Err(code) => return code,
    };
    let done = match matches.subcommand() {
        Some(("completions", matches)) => match matches.get_one::<String>("shell").map(|name| name.parse()) {
            Some(Ok(shell)) => completions(shell, command),
            _ => manual(matches.get_one("folder").map_or(Path::new("."), PathBuf::as_path), command),
        },
        Some(("verify", matches)) => {
            Verify::from_arg_matches(matches).map_err(|e| Failure::Usage(e.to_string())).and_then(|verify| {
                set_budget(matches.get_one("memory_mib").copied());
                verify.run()
            })
        }
        Some((name, matches)) => {
            let stage = subcommands().find(|stage| stage.command().get_name() == name);
            return stage.map_or(ExitCode::FAILURE, |stage| stage.run(matches));
        }
        None => Ok(()),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => ended(&failure, false),
    }
}

/// What begins a study, and what runs all of it.
const OWN: [Stage; 2] = [Stage::of::<ships::NewArguments>(), Stage::of::<RunArguments>()];

/// The program's own subcommands that write files, and the stages.
fn subcommands() -> impl Iterator<Item = &'static Stage> {
    OWN.iter().chain(STAGES)
}

/// Its command line.
pub fn command() -> Command {
    let names = Shell::value_variants().iter().filter_map(ValueEnum::to_possible_value);
    let names = PossibleValuesParser::new(names.chain([PossibleValue::new(PAGES)]));
    let shell = Arg::new("shell").required(true).value_parser(names).help("The shell, or the manual");
    let folder = Arg::new("folder").value_name("FOLDER").value_parser(value_parser!(PathBuf));
    let folder = folder.required_if_eq("shell", PAGES).help("Of the manual pages; made if there is none");
    let completions = Command::new("completions")
        .about("Prints what a shell completes this program's command lines with, or writes its manual pages")
        .args([shell, folder])
        .after_help(
            "Example:\n  completions bash > ~/.local/share/bash-completion/completions/seatrial\n  \
            completions man ~/.local/share/man/man1/",
        );
    let all = Command::new("seatrial")
        .about("Plans the shortest sea trial that identifies a ship's manoeuvring model")
        .after_help(
            "Example:\n  simulate dictionary --vessel pipelines/smoke/vessel.toml \
            --dictionary pipelines/smoke/dictionary.toml --out dictionary.parquet",
        )
        .subcommand_required(true)
        .arg_required_else_help(true)
        .subcommands(subcommands().map(Stage::command))
        .subcommands([Verify::command(), completions]);
    named(dressed(all))
}

/// `command` with examples that begin with `seatrial`.
fn named(command: Command) -> Command {
    let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
    let lines = help.lines().map(|line| match line.strip_prefix("  ") {
        Some(example) => format!("  seatrial {example}"),
        None => line.to_owned(),
    });
    let help = lines.collect::<Vec<_>>().join("\n");
    command.after_help(help).mut_subcommands(named)
}

/// What the manual is called among the shells.
const PAGES: &str = "man";

/// Prints the completions of `command` for `shell`.
pub fn completions(shell: Shell, mut command: Command) -> Result<(), Failure> {
    let (mut script, name) = (Vec::new(), command.get_name().to_owned());
    clap_complete::generate(shell, &mut command, name, &mut script);
    printed(std::io::stdout().write_all(&script))
}

/// Writes the manual pages of `command` and its subcommands into `folder`.
pub fn manual(folder: &Path, command: Command) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).map_err(|e| files::Error::io(folder, "create", e))?;
    let mut command = without_help(command);
    command.build();
    let mut staged = Vec::new();
    pages(&command, folder, &mut staged)?;
    let count = staged.len();
    commit(staged)?;
    on_stdout(format_args!("{}: {count} pages", folder.display()))
}

/// `command` without the subcommands that print help, which pages are in place of.
fn without_help(command: Command) -> Command {
    command.disable_help_subcommand(true).mut_subcommands(without_help)
}

/// A page for `command` and each of its subcommands.
fn pages(command: &Command, folder: &Path, staged: &mut Vec<Staged>) -> Result<(), Failure> {
    let man = Man::new(command.clone());
    let mut page = Vec::new();
    man.render(&mut page).map_err(|e| Failure::Failed(format!("{}: {e}", man.get_filename())))?;
    staged.push(Staged::bytes(folder.join(man.get_filename()), &page)?);
    let mut others = command.get_subcommands().filter(|below| below.get_name() != "help");
    others.try_for_each(|below| pages(below, folder, staged))
}

/// What the name of the study stands in for in the usual folder of results.
const USUAL: &str = "out/<study>";

/// Runs all stages of a study and ends with its page; what is up to date is not run again
#[derive(Parser)]
#[command(
    name = "run",
    after_help = "What is up to date is known by digests of inputs and outputs, which run.json in the folder of the results has.\n\n\
    Example:\n  run pipelines/smoke --out out/smoke"
)]
pub struct RunArguments {
    /// Folder of the study's hand-written files
    #[arg(value_name = "FOLDER")]
    whole_study: PathBuf,
    /// Folder of the logs (default: `logs` of study.toml, or logs in the study's folder)
    #[arg(long, value_name = "FOLDER")]
    logs: Option<PathBuf>,
    /// Ends with this stage, after those that it needs
    #[arg(long, value_name = "STAGE")]
    stage: Option<String>,
    /// Folder for the results
    #[arg(long, value_name = "FOLDER", default_value = USUAL)]
    out: PathBuf,
}

impl Task for RunArguments {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let out = self.results();
        let settings = StudySettings::read(&self.whole_study, common.changes())?;
        let mut pipeline = Pipeline::read(&self.whole_study, &out, &settings, self.logs.as_deref())?;
        if let Some(stage) = &self.stage {
            pipeline.until(stage).map_err(|e| Failure::Usage(format!("--stage: {e}")))?;
        }
        let commands = commands(&pipeline, common)?;
        refuse_device(&out)?;
        std::fs::create_dir_all(&out).map_err(|e| Error::io(&out, "create", e))?;
        let Provenance { producer, .. } = common.provenance("seatrial");
        let program = std::env::current_exe().ok().and_then(|file| Digest::of_file(file).ok());
        let (mut record, mut ran, mut without) =
            (RunRecord::read(&out, producer, program), Vec::new(), Vec::new());
        record.belong_to(&pipeline)?;
        for (i, (step, words)) in pipeline.steps.iter().zip(&commands).enumerate() {
            if step.is_optional && !without.is_empty() {
                record.forget(&pipeline, step)?;
                without.push(step.name.as_str());
                continue;
            }
            let is_current = record.is_current(&pipeline, step, words);
            if !common.quiet {
                let state = if is_current { "up to date".to_owned() } else { shown(&pipeline, words) };
                on_stderr(format_args!("[{}/{}] {}: {state}", i + 1, commands.len(), step.name));
            }
            if is_current {
                continue;
            }
            match run_one(&pipeline, step, words, common) {
                Ok(trace) => record.note(&pipeline, step, words, &trace)?,
                Err(Failure::Refused(why) | Failure::NoAnswer(why)) if step.is_optional => {
                    on_stderr(format_args!("without {}: {why}", step.name));
                    without.push(step.name.as_str());
                    record.forget(&pipeline, step)?;
                    continue;
                }
                Err(failure) => return Err(failure),
            }
            ran.push(step.name.as_str());
        }
        let all = pipeline.steps.len();
        let current = all - ran.len() - without.len();
        let mut said = format!("{} of {all} stages run, {current} up to date", ran.len());
        if !without.is_empty() {
            said += &format!(", without {}", without.join(", "));
        }
        let last = pipeline.steps.last().map_or(out, |step| pipeline.main(step));
        Ok(Summary::of(&last, said, json!({"stages": all, "run": ran, "without": without})))
    }
}

impl RunArguments {
    /// The folder for the results, named after the study if it is not given.
    fn results(&self) -> PathBuf {
        if self.out != Path::new(USUAL) {
            return self.out.clone();
        }
        // A folder that is not there is refused when it is read.
        let study = self.whole_study.canonicalize().unwrap_or_else(|_| self.whole_study.clone());
        Path::new("out").join(study.file_name().unwrap_or_default())
    }
}

/// The command line of every stage, with the changes to the files that it reads.
fn commands(pipeline: &Pipeline, common: &Common) -> Result<Vec<Vec<String>>, Failure> {
    // Those of study.toml are in the command lines.
    let mut used: Vec<bool> = common.set.iter().map(|change| change.file() == "study").collect();
    let mut all = Vec::with_capacity(pipeline.steps.len());
    for step in &pipeline.steps {
        let (stage, matches) = parsed(pipeline, &step.words)?;
        let mut words = step.words.clone();
        for (change, used) in common.set.iter().zip(&mut used) {
            if stage.takes(&matches, change) {
                words.extend(["--set".to_owned(), format!("{}={}", change.key(), change.value())]);
                *used = true;
            }
        }
        if let Some(seed) = common.seed {
            words.extend(["--seed".to_owned(), seed.to_string()]);
        }
        words.extend(common.allow.iter().map(|allowed| format!("--allow={}", allowed.name())));
        all.push(words);
    }
    match used.iter().position(|used| !used) {
        None => Ok(all),
        Some(unused) => {
            let (found, expected) = (common.set[unused].file(), "a file that a stage of this run reads");
            let invalid = Invalid::new("file", format!("`{found}`"), expected, "correct or remove it");
            Err(Failure::Usage(format!("--set: {invalid}")))
        }
    }
}

/// The command that `words` are, as one may call it.
fn shown(pipeline: &Pipeline, words: &[String]) -> String {
    let words = words.iter().map(|word| pipeline.resolved(word).to_string_lossy().into_owned());
    format!("seatrial {}", words.collect::<Vec<_>>().join(" "))
}

/// Runs `step` with these `words`, and returns what it read and wrote.
fn run_one(
    pipeline: &Pipeline,
    step: &StudyStep,
    words: &[String],
    common: &Common,
) -> Result<Trace, Failure> {
    let main = pipeline.main(step);
    let (stage, matches) = parsed(pipeline, words)?;
    let (task, mut of_stage) = stage.task(&matches)?;
    of_stage.quiet = common.quiet;
    pipeline.trace()?;
    check_within(folder_of(&main))?;
    std::fs::create_dir_all(folder_of(&main)).map_err(|e| Error::io(&main, "create", e))?;
    let summary = task.run(&of_stage)?;
    if !common.quiet {
        on_stderr(summary.line);
    }
    Ok(traced())
}

/// The stage that `words` call, and its flags.
fn parsed(pipeline: &Pipeline, words: &[String]) -> Result<(&'static Stage, ArgMatches), Failure> {
    let name = &words[0];
    let Some(stage) = STAGES.iter().find(|stage| stage.command().get_name() == name) else {
        return Err(Failure::Failed(format!("{name}: found no such stage, expected one")));
    };
    let words = words.iter().map(|word| pipeline.resolved(word));
    let matches = stage.command().try_get_matches_from(words).map_err(|error| {
        let (file, why) = (pipeline.folders.study.join(settings::FILE), misused(&error).to_string());
        let remedy = format!("correct the settings of this stage; see `seatrial {name} --help`");
        let why = why.trim_end_matches("; see --help");
        Failure::refuse(&file, &format!("flags of `{name}`"), why, "what the stage takes", &remedy)
    })?;
    Ok((stage, matches))
}

/// Checks that files are whole and belong together, and prints what was made of what
#[derive(Parser)]
#[command(
    name = "verify",
    after_help = "A file that is not in the folder is shown by its role alone; name the hand-written ones with --study.\n\n\
    Example:\n  verify out/paper --study pipelines/paper"
)]
pub struct Verify {
    /// Folders that the stages wrote into, with those below them
    #[arg(required = true, value_name = "FOLDER")]
    folders: Vec<PathBuf>,
    /// Folder of the hand-written files, where the folders are of one study
    #[arg(long, value_name = "FOLDER")]
    study: Option<PathBuf>,
}

impl Verify {
    /// Prints the graph and the errors.
    pub fn run(&self) -> Result<(), Failure> {
        for root in &self.folders {
            let mut folder = Folder::read(root, self.study.as_deref())?;
            if let Some(study) = &self.study {
                let folders = Folders { study: study.clone(), out: root.clone() };
                folder.faults.extend(RunRecord::read(root, String::new(), None).faults(&folders));
            }
            folder.lines(root).into_iter().try_for_each(on_stdout)?;
            folder.faults.iter().try_for_each(|fault| on_stdout(format_args!("fault: {fault}")))?;
            let (files, faults) = (folder.count(), folder.faults.len());
            if faults > 0 {
                let (found, expected) =
                    (format!("{faults} faults in {files} files"), "whole files of one study");
                let remedy = "make again what is named above";
                return Err(Failure::refuse(root, "files", &found, expected, remedy));
            }
            on_stdout(format_args!("{}: {files} files, whole and of one study", root.display()))?;
        }
        Ok(())
    }
}
