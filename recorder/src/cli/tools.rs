//! The commands that work on files.

use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};

use super::stretch::moment;
use crate::edit::attach::{AttachError, attach};
use crate::edit::cut::{CutError, Stretch, cut};
use crate::edit::export::follow::FollowMarkers;
use crate::edit::export::{ExportError, Exported, ExportedImages, Format, export, export_images};
use crate::edit::import::{ImportError, import};
use crate::read::damage::OpenError;
use crate::read::verify::verify;
use crate::report::{Made, ReportError, Wanted, report};

const EXPORT_HELP: &str = "\
CSV and JSON bring back every number bit for bit; a lost pose has no numbers there, and its words say why. MHA is the \
PLUS toolkit's: one transform a pose, INVALID where it was lost. Topics: /tool_pose, /ground_truth, /emitters, /status, \
/log.

--images writes the images of the ultrasound probe bit for bit, each with ProbeToTracker (the marker on the probe) and \
ReferenceToTracker at its own stamp, straight between the localizer's frames before and after it, as PLUS does: calib lag and \
calib probe read it. INVALID is what has no such frame within 150 ms, a frame without a pose beside it, or a stamp of its arrival. \
Whatever images are late by is not taken out.

Examples:
  recorder export csv session.mcap --out poses.csv
  recorder export csv session.mcap --topic /emitters --out emitters.csv
  recorder export mha session.mcap --topic /ground_truth --out truth.mha
  recorder export mha session.mcap --images --out tank.igs.mha";

const IMPORT_HELP: &str = "\
The transform is taken as the tool's pose in the examination; what the sequence calls it is kept in the recording. \
One that the sequence does not hold is composed of those that lead there by the shortest way, each forwards or backwards: \
StylusTipToReference of StylusTipToStylus, StylusToTracker and ReferenceToTracker. A pose is lost where any of them is; where another \
way ends elsewhere nothing is imported. Names are case sensitive. Times count from the sequence's first frame.

Example:
  recorder import tracked.mha --transform StylusToReference --out tracked.mcap";

const CUT_HELP: &str = "\
Times are seconds of the run, as `recorder info` shows them; both ends belong to the stretch. Attached files stay.

Examples:
  recorder cut session.mcap --from 3.2s --to 9s --out insertion.mcap
  recorder cut session.mcap --from 2m --out rest.mcap";

const VERIFY_HELP: &str = "\
Reads everything: the CRC of every chunk and attachment and of the whole file, every message against its schema and its \
header, the order of captures, and the index against what is there; and that it is of one run, with one scene. Exit code 1 where anything is wrong. A file of another \
program is whole without an index too, as MCAP does not ask for one: that is said. A file of Trocar's must have it.

Example:
  recorder verify session.mcap";

const ATTACH_HELP: &str = "\
Only whole recordings, and no name that is attached already. Messages are not touched; the index is written anew.

Example:
  recorder attach session.mcap report.json";

const REPORT_HELP: &str = "\
One HTML file that needs no other, no network and no script: what the session rests on, chosen targets, marks with their pictures, \
times without a pose, errors at the tip, latencies, restarts and problems. It prints on A4. What makes less of a recording than it \
seems (damage, a missing end, a replay, simulated time) stands at its top, and on stderr. Whose examination it is, is in it only with \
--identity. The files are readable by their user only. Unfinished and damaged recordings are reported as far as they can be read.

Examples:
  recorder report session.mcap --out report.html
  recorder report session.mcap --out report.html --json      report.json beside it: the same facts
  recorder report session.mcap.recording --out report.html   of a run that was killed";

#[derive(Debug, Subcommand)]
pub(super) enum Tool {
    /// Write the messages of a topic as CSV, JSON or MHA
    #[command(after_help = EXPORT_HELP)]
    Export(ExportArgs),
    /// Make a recording of a PLUS sequence (MHA)
    #[command(after_help = IMPORT_HELP)]
    Import(ImportArgs),
    /// Make a recording of a stretch of another
    #[command(after_help = CUT_HELP)]
    Cut(CutArgs),
    /// Make one page of a recording: what was done, on what it rested, what went wrong
    #[command(after_help = REPORT_HELP)]
    Report(ReportArgs),
    /// Check every CRC, message and count of a recording
    #[command(after_help = VERIFY_HELP)]
    Verify {
        /// The recording
        file: PathBuf,
    },
    /// Attach a file to a whole recording
    #[command(after_help = ATTACH_HELP)]
    Attach {
        /// The recording
        session: PathBuf,
        /// The file
        file: PathBuf,
    },
}

#[derive(Debug, Args)]
pub(super) struct ExportArgs {
    /// The form of the new file
    format: Format,
    /// The recording, whole or not
    input: PathBuf,
    /// Whose messages
    #[arg(long, value_name = "TOPIC", default_value = crate::wire::schema::TOOL_POSE)]
    topic: String,
    /// The images of the ultrasound probe, with the poses of the markers at their stamps, instead of a topic; mha only
    #[arg(long, conflicts_with = "topic")]
    images: bool,
    /// The new file
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Replace the new file if it exists
    #[arg(long)]
    force: bool,
}

#[derive(Debug, Args)]
pub(super) struct ImportArgs {
    /// The sequence
    input: PathBuf,
    /// Which of its transforms, or of what they compose, is the tool's pose [default: the only one]
    #[arg(long, value_name = "NAME")]
    transform: Option<String>,
    /// The recording
    #[arg(long, value_name = "FILE.mcap")]
    out: PathBuf,
    /// Replace the recording if it exists
    #[arg(long)]
    force: bool,
}

#[derive(Debug, Args)]
pub(super) struct CutArgs {
    /// The recording, whole or not
    input: PathBuf,
    /// First capture [default: the beginning]
    #[arg(long, value_name = "TIME", value_parser = moment)]
    from: Option<u64>,
    /// Last capture [default: the end]
    #[arg(long, value_name = "TIME", value_parser = moment)]
    to: Option<u64>,
    /// The new recording
    #[arg(long, value_name = "FILE.mcap")]
    out: PathBuf,
    /// Replace the new recording if it exists
    #[arg(long)]
    force: bool,
}

#[derive(Debug, Args)]
pub(super) struct ReportArgs {
    /// The recording, whole or not
    input: PathBuf,
    /// The page
    #[arg(long, value_name = "FILE.html")]
    out: PathBuf,
    /// Say whose examination it is, where the recording says so
    #[arg(long)]
    identity: bool,
    /// Write the same facts as JSON too, beside the page
    #[arg(long)]
    json: bool,
    /// Replace the files if they exist
    #[arg(long)]
    force: bool,
}

#[derive(Debug, thiserror::Error)]
pub(super) enum ToolError {
    #[error(transparent)]
    Report(#[from] ReportError),
    #[error(transparent)]
    Export(#[from] ExportError),
    #[error(transparent)]
    Import(#[from] ImportError),
    #[error(transparent)]
    Cut(#[from] CutError),
    #[error(transparent)]
    Attach(#[from] AttachError),
    #[error(transparent)]
    Open(#[from] OpenError),
    #[error("{path}: {found} findings:\n{}", findings.join("\n"))]
    Findings {
        path: PathBuf,
        found: u64,
        findings: Vec<String>,
    },
}

/// Does what is asked, and says what came of it.
pub(super) fn run(tool: Tool, follow: FollowMarkers) -> Result<String, ToolError> {
    match tool {
        Tool::Export(args) if args.images => {
            let form = match args.format {
                Format::Mha => None,
                Format::Csv => Some("table (CSV)"),
                Format::Json => Some("JSON"),
            };
            if let Some(form) = form {
                return Err(ExportError::ImagesAs(form).into());
            }
            let exported = export_images(&args.input, follow, &args.out, args.force)?;
            Ok(said_of_images(&args.out, &exported))
        }
        Tool::Export(args) => {
            let exported = export(&args.input, &args.topic, args.format, &args.out, args.force)?;
            Ok(said_of_export(&args.out, exported))
        }
        Tool::Import(args) => {
            let imported = import(&args.input, args.transform.as_deref(), &args.out, args.force)?;
            let (out, name) = (args.out.display(), imported.transform);
            let (frames, lost) = (imported.frames, imported.lost);
            Ok(format!(
                "{out}: {frames} poses, {lost} of them lost; {name} was taken as the tool's pose in the examination\n"
            ))
        }
        Tool::Cut(args) => {
            let stretch = Stretch {
                from_ns: args.from.unwrap_or(0),
                to_ns: args.to.unwrap_or(u64::MAX),
            };
            let info = cut(&args.input, stretch, &args.out, args.force)?;
            Ok(format!("{}\n{info}", args.out.display()))
        }
        Tool::Report(args) => {
            let (identity, json, force) = (args.identity, args.json, args.force);
            let made = report(&args.input, &args.out, Wanted { identity, json, force })?;
            Ok(said_of_report(&made))
        }
        Tool::Verify { file } => verified(file),
        Tool::Attach { session, file } => {
            attach(&session, &file)?;
            Ok(format!("{} is attached to {}\n", file.display(), session.display()))
        }
    }
}

fn said_of_export(out: &Path, exported: Exported) -> String {
    let Exported { messages, unreadable } = exported;
    let rest = match unreadable {
        0 => String::new(),
        n => format!("; {n} parts of the recording could not be read: `recorder verify` names them"),
    };
    format!("{}: {messages} messages{rest}\n", out.display())
}

fn said_of_images(out: &Path, exported: &ExportedImages) -> String {
    let counted = |count: u64, words: String| (count > 0).then(|| format!("; {count} {words}"));
    let more = [
        counted(
            exported.unposed,
            format!("of them without a pose, the last one as {}", exported.why),
        ),
        counted(
            exported.left_out,
            "more left out, whose stamp is not after that of the image before".to_owned(),
        ),
        counted(
            exported.unreadable,
            "parts of the recording could not be read: `recorder verify` names them".to_owned(),
        ),
        exported
            .is_cut_off
            .then(|| "; THE RECORDING ENDS WITHIN A RECORD: images behind that are missing".to_owned()),
    ];
    let more: String = more.into_iter().flatten().collect();
    let options = exported.options.as_ref();
    let options = options.map_or(String::new(), |options| format!("for calib probe: {options}\n"));
    format!("{}: {} images{more}\n{options}", out.display(), exported.images)
}

fn said_of_report(made: &Made) -> String {
    for notice in &made.notices {
        bus::stderr_line!("recorder: {notice}");
    }
    let names = made.files.iter().map(|file| format!("{}\n", file.display()));
    names.collect()
}

fn verified(path: PathBuf) -> Result<String, ToolError> {
    let verified = verify(&path)?;
    let (found, mut findings) = (verified.found, verified.findings);
    if found == 0 {
        let (messages, attachments) = (verified.messages, verified.attachments);
        let left_out: String = verified.left_out.iter().map(|words| format!("; {words}")).collect();
        return Ok(format!(
            "{}: whole; {messages} messages, {attachments} attached files{left_out}\n",
            path.display()
        ));
    }
    if found > findings.len() as u64 {
        findings.push(format!("and {} more", found - findings.len() as u64));
    }
    Err(ToolError::Findings { path, found, findings })
}
