//! The command line.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};
use organs::read;

use crate::model::Model;
use crate::output::{self, Plan};
use crate::scene::{Source, is_of_space};
use crate::space::{ReadLabels, Space};
use crate::{run, words};

/// Finds equilibria of rigid and deformable solids: in the plane, or organs of a label map that a tube pushes.
#[derive(Debug, Parser)]
#[command(name = "simulate", version, after_help = TOP_HELP)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

const TOP_HELP: &str = "\
Examples:
  simulate check config/solids/figure-40.toml
  simulate run config/solids/figure-40.toml --out out/figure-40
  simulate run config/solids/tube.toml --out out/tube
  simulate run config/solids/kidney.toml --out out/kidney

Scenes are described in docs/simulate.md.";

const RUN_HELP: &str = "\
Writes into DIR:
  start.png, shape.png, energy.png, ...   the start, and the last state with the fields that the scene names
  strip.png, film.png                     how it came about, as a strip and as an animated PNG
  result.json                             every state: certificate, steps, times, least det F, contact forces, the force
                                          on each wall and each instrument, and how far each was moved

Of a scene in space: start.png, shape.png and cuts.png (three cuts through the tube's tip), strip.png, film.png, and in
result.json force and moment on the tube and the places of targets in every state; it is written anew after each state.
--errors (or [output] errors = true) adds, for the last state, three kinds of error at each target and of the force: what the
search left over, what cubes half as large change, and what numbers with a young_spread or poisson_spread do.

A line for each state goes to stderr. Exit code 1 where an equilibrium is not found; what was found until then is written
all the same, and result.json says why (key refused).

Examples:
  simulate run config/solids/figure-37.toml --out out/figure-37
  simulate run config/solids/figure-36.toml --out out/figure-36 --overwrite --quiet
  simulate run config/solids/kidney.toml --out out/kidney --labels segmentation.nii.gz
  simulate run config/solids/kidney.toml --out out/kidney --errors";

const CHECK_HELP: &str = "\
Reads and checks everything that a run would, overlaps at the start included, and says what is modelled: solids, unknowns,
walls, links, contact, steps. What it does not name is not modelled. Of a scene in space the label map is read and meshed.

Examples:
  simulate check config/solids/tube.toml
  simulate check config/solids/kidney.toml --labels segmentation.nii.gz";

#[derive(Debug, Subcommand)]
enum Command {
    /// Find the equilibria of a scene, and draw them
    #[command(after_help = RUN_HELP)]
    Run(RunArgs),
    /// Check a scene and say what it models
    #[command(after_help = CHECK_HELP)]
    Check(CheckArgs),
}

#[derive(Debug, Args)]
struct RunArgs {
    /// The scene file
    scene: PathBuf,
    /// The folder of the results; it is made, and must be empty
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Replace results in that folder
    #[arg(long)]
    overwrite: bool,
    /// No line for each state
    #[arg(long)]
    quiet: bool,
    /// The label map of a scene in space, instead of the one that it names
    #[arg(long, value_name = "FILE")]
    labels: Option<PathBuf>,
    /// Look for the errors of the last state of a scene in space: algebraic, of the mesh, of the model (takes longer than the run)
    #[arg(long)]
    errors: bool,
}

#[derive(Debug, Args)]
struct CheckArgs {
    /// The scene file
    scene: PathBuf,
    /// The label map of a scene in space, instead of the one that it names
    #[arg(long, value_name = "FILE")]
    labels: Option<PathBuf>,
}

/// The command line, for manual pages and completions.
pub fn command() -> clap::Command {
    <Cli as clap::CommandFactory>::command()
}

/// Runs the `simulate` command line of this process; `read_labels` reads the label maps of scenes in space.
pub fn main(read_labels: ReadLabels) -> ExitCode {
    let done = match Cli::parse().command {
        Command::Run(args) => simulate(&args, read_labels),
        Command::Check(args) => check(&args, read_labels),
    };
    match done {
        Ok(text) => {
            // Where nobody reads stdout any more, there is nobody to tell.
            let _ = std::io::stdout().write_all(text.as_bytes());
            ExitCode::SUCCESS
        }
        Err(error) => {
            say(&format!("error: {error}"));
            ExitCode::FAILURE
        }
    }
}

/// Says something on stderr. Where it cannot be written to, the line is lost.
fn say(words: &str) {
    let _ = std::io::stderr().write_all(format!("simulate: {words}\n").as_bytes());
}

/// A scene of either kind with what it describes.
enum Scene {
    Plane(Box<(Source, Model, Plan)>),
    Space(Box<Space>),
}

fn checked(path: &Path, labels: Option<&Path>, read_labels: ReadLabels) -> Result<Scene, String> {
    let shipped = ::scene::shipped::instead_of(path);
    if let Some(shipped) = &shipped {
        say(&format!("{}: the shipped scene {}", path.display(), shipped.display()));
    }
    let path = shipped.as_deref().unwrap_or(path);
    let text = read(path).map_err(|error| error.to_string())?;
    if is_of_space(&text) {
        return Ok(Scene::Space(Box::new(Space::new(text, path, labels, read_labels)?)));
    }
    if labels.is_some() {
        return Err(format!(
            "{}: --labels is for scenes in space, which have a table [space]",
            path.display()
        ));
    }
    let source = Source::parse(text, path).map_err(|error| error.to_string())?;
    let (model, plan) = modelled(&source)?;
    Ok(Scene::Plane(Box::new((source, model, plan))))
}

fn check(args: &CheckArgs, read_labels: ReadLabels) -> Result<String, String> {
    Ok(match checked(&args.scene, args.labels.as_deref(), read_labels)? {
        Scene::Plane(plane) => words::described(&plane.0.scene, &plane.1),
        Scene::Space(space) => space.described(),
    })
}

/// What a scene models and draws, or what is wrong with it.
pub(crate) fn modelled(source: &Source) -> Result<(Model, Plan), String> {
    let model = Model::new(&source.scene).map_err(|invalid| source.error_at(invalid).to_string())?;
    let plan = Plan::new(&source.scene.output, &model).map_err(|invalid| source.error_at(invalid).to_string())?;
    Ok((model, plan))
}

fn simulate(args: &RunArgs, read_labels: ReadLabels) -> Result<String, String> {
    let scene = checked(&args.scene, args.labels.as_deref(), read_labels)?;
    if args.errors && matches!(scene, Scene::Plane(_)) {
        return Err(format!(
            "{}: --errors is for scenes in space, which have a table [space]",
            args.scene.display()
        ));
    }
    output::folder(&args.out, args.overwrite).map_err(|error| error.to_string())?;
    let mut tell = |line: &str| {
        if !args.quiet {
            say(line);
        }
    };
    let (source, mut model, plan) = match scene {
        Scene::Plane(plane) => *plane,
        Scene::Space(mut space) => {
            if args.errors {
                space.ask_for_errors();
            }
            return space.run(&args.out, &mut tell);
        }
    };
    let found = run::run(&mut model, &source.scene.search, &mut tell);
    let pictures = output::write(&source.scene, &model, &found, &plan, &args.out).map_err(|error| error.to_string())?;
    let uncertified = found.uncertified();
    let out = args.out.display();
    match (&found.refused, uncertified.first()) {
        (Some(why), _) => Err(format!(
            "{}: {why}. What was found until then is in {out}",
            source.path.display()
        )),
        (None, Some(first)) => Err(format!(
            "{}: {} of {} states are NOT certified, first {first}. Raise search.most_steps, change contact.widths, or set \
             search.exact = false to end frames behind barriers. All states are in {out}",
            source.path.display(),
            uncertified.len(),
            found.states.len(),
        )),
        (None, None) => Ok(format!(
            "{}; {} and result.json in {out}\n",
            words::certified(&found),
            pictures.join(", "),
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent_and_shows_examples() {
        let mut command = Cli::command();
        command.clone().debug_assert();
        for name in ["run", "check"] {
            let help = command.find_subcommand_mut(name).unwrap().render_help().to_string();
            assert!(help.contains("Example"), "{help}");
        }
        assert!(Cli::try_parse_from(["simulate", "run", "a.toml"]).is_err());
    }
}
