//! `volume-loader receive`.

use std::path::PathBuf;
use std::time::Duration;

use bus::process::{JoinError, StopFlag};
use clap::Args;
use scene::{Invalid, PacsSpec, RawPacs, Scene, SceneError, raw};

use super::inspect::{self, InspectArgs};
use crate::receive::{Came, Limits, Outcome, Rules, ServeError, Server, Store, StoreError};

/// MiB of bytes.
const MIB: u64 = 1 << 20;

/// From whom to receive, where to, and how much.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  \
    volume-loader receive --out incoming\n  \
    volume-loader receive --out incoming --aet TROCAR --from ORTHANC --once\n  \
    volume-loader receive --out incoming --listen 192.168.0.3:11112 --expose --from ORTHANC\n  \
    volume-loader receive --out incoming --scene scene.toml\n\n\
    A series lands in DIR/STUDY/SERIES/INSTANCE.dcm, by its unique identifiers; while it comes, and after an association that broke off, \
    in the hidden folder DIR/STUDY/.SERIES.incomplete. After each association what came is inspected as by `volume-loader inspect`. \
    DICOM does not say how many slices a series has: compare what is told with the sender.\n\n\
    Taken are CT, Enhanced CT, Legacy Converted Enhanced CT, segmentations and RT structure sets, in the codings that are read; \
    verification (C-ECHO) is answered. Nothing is sent to anybody. One association at a time: who comes meanwhile is told so \
    (temporary congestion). Titles are no passwords, and nothing is encrypted.")]
pub(crate) struct ReceiveArgs {
    /// The folder for what comes; made for its owner alone where there is none.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// A scene, whose [pacs] table says what the options below leave open.
    #[arg(long, value_name = "SCENE")]
    scene: Option<PathBuf>,
    /// Where to listen: an IP address and a port [default: 127.0.0.1:11112].
    #[arg(long, value_name = "ADDRESS")]
    listen: Option<String>,
    /// Lets other machines connect, where --listen names an address that they reach.
    #[arg(long)]
    expose: bool,
    /// The title by which this program is called [default: TROCAR].
    #[arg(long, value_name = "TITLE")]
    aet: Option<String>,
    /// A title that may send; again for each. Without any, whoever reaches the address.
    #[arg(long, value_name = "TITLE")]
    from: Vec<String>,
    /// Ends after the first association that sent an instance: with 0 if all of it is kept and each examination can be read, else 1.
    #[arg(long)]
    once: bool,
    /// An instance of more is refused, MiB.
    #[arg(long, value_name = "MIB", default_value_t = Limits::default().instance_bytes / MIB,
          value_parser = clap::value_parser!(u64).range(1..=1 << 20))]
    max_instance_mib: u64,
    /// What is beyond this of an association is refused, MiB.
    #[arg(long, value_name = "MIB", default_value_t = Limits::default().association_bytes / MIB,
          value_parser = clap::value_parser!(u64).range(1..=1 << 20))]
    max_association_mib: u64,
    /// Instances beyond these of an association are refused.
    #[arg(long, value_name = "N", default_value_t = Limits::default().instances,
          value_parser = clap::value_parser!(u64).range(1..=100_000))]
    max_instances: u64,
    /// Instances are refused where the disk has less left, MiB.
    #[arg(long, value_name = "MIB", default_value_t = Limits::default().free_bytes / MIB,
          value_parser = clap::value_parser!(u64).range(0..=1 << 30))]
    min_free_mib: u64,
    /// A sender that is silent for so long, or takes as long for one PDU of at most 128 KiB, is cut off, s.
    #[arg(long, value_name = "S", default_value_t = Limits::default().silence.as_secs(),
          value_parser = clap::value_parser!(u64).range(1..=3600))]
    silence_s: u64,
}

/// Why nothing is received, or not all of it.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ReceiveError {
    /// The scene was refused.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// An option has a value that is not allowed.
    #[error("{option}: found {}; allowed: {}", invalid.found, invalid.allowed)]
    Option {
        /// The option.
        option: &'static str,
        /// What is wrong.
        invalid: Invalid,
    },
    /// The folder cannot be used.
    #[error("--out: {0}")]
    Store(#[from] StoreError),
    /// The process cannot be asked to stop.
    #[error(transparent)]
    Signals(#[from] JoinError),
    /// The port.
    #[error(transparent)]
    Serve(#[from] ServeError),
}

impl ReceiveArgs {
    /// The scene's table, with the options in front of it.
    fn pacs(&self) -> Result<PacsSpec, ReceiveError> {
        let mut pacs = match &self.scene {
            None => RawPacs::default(),
            Some(path) => {
                let source = raw::load(path)?;
                // All of it is checked, so that an error names its line.
                Scene::from_raw(&source)?;
                source.scene.pacs.unwrap_or_default()
            }
        };
        if let Some(address) = &self.listen {
            // That a scene exposes its own address exposes no other.
            (pacs.address, pacs.expose) = (address.clone(), false);
        }
        pacs.expose |= self.expose;
        pacs.aet = self.aet.clone().unwrap_or(pacs.aet);
        if !self.from.is_empty() {
            pacs.from.clone_from(&self.from);
        }
        pacs.checked().map_err(|invalid| {
            let option = match invalid.key.as_str() {
                "pacs.address" => "--listen",
                "pacs.aet" => "--aet",
                _ => "--from",
            };
            ReceiveError::Option { option, invalid }
        })
    }

    fn limits(&self) -> Limits {
        Limits {
            instance_bytes: self.max_instance_mib * MIB,
            association_bytes: self.max_association_mib * MIB,
            instances: self.max_instances,
            free_bytes: self.min_free_mib * MIB,
            silence: Duration::from_secs(self.silence_s),
        }
    }
}

/// Receives until it is stopped, or once.
///
/// # Errors
/// [`ReceiveError`].
pub(crate) fn run(args: &ReceiveArgs) -> Result<(), ReceiveError> {
    let (pacs, limits) = (args.pacs()?, args.limits());
    let store = Store::open(&args.out)?;
    let stop = StopFlag::install(false)?;
    let from = match pacs.from.as_slice() {
        [] => "whoever reaches it".to_owned(),
        from => from.join(", "),
    };
    let (aet, folder) = (pacs.aet.clone(), args.out.display());
    let server = Server::bind(Rules { pacs, limits }, store, stop, args.once, Box::new(report))?;
    let address = server.address();
    bus::stderr_line!("volume-loader: listening on {address} as {aet}, from {from}, into {folder}");
    Ok(server.serve()?)
}

/// Tells what came of each series, and inspects what may be an examination; whether all of it is kept and can be read.
fn report(outcome: &Outcome) -> bool {
    let told: Vec<bool> = outcome.series.iter().map(of_series).collect();
    outcome.is_kept() && told.into_iter().all(|is_right| is_right)
}

fn of_series(came: &Came) -> bool {
    let path = came.path.display();
    if came.stored + came.same == 0 {
        bus::stderr_line!(
            "volume-loader: {path}: none of the {} instances that were sent is kept",
            came.refused
        );
        return false;
    }
    if let (true, Some(why)) = (came.is_hidden, &came.lacking) {
        // Before what is told of it, also for who reads that alone.
        inspect::say(&format!("INCOMPLETE: {why}\n"));
    }
    let is_readable = match came.is_slices {
        true => inspect::run(&InspectArgs::of(came.path.clone()))
            .map_err(|error| bus::stderr_line!("volume-loader: {path}: it cannot be loaded: {error}"))
            .is_ok(),
        false => {
            bus::stderr_line!(
                "volume-loader: {path}: no examination (a segmentation or a structure set); it is not looked into"
            );
            true
        }
    };
    let Came { stored, same, .. } = came;
    let counts = format!("{stored} instances are new, {same} were there already");
    match (&came.lacking, came.is_hidden) {
        (None, _) if came.is_slices && is_readable => bus::stderr_line!(
            "volume-loader: {path}: {counts}; it can be loaded, each volume with no gap between its first and its last slice. Whether these are \
             all slices of the series is known to the sender alone"
        ),
        (None, _) => bus::stderr_line!("volume-loader: {path}: {counts}"),
        (Some(why), true) => bus::stderr_line!(
            "volume-loader: {path}: INCOMPLETE: {why}. {counts}. Send the whole series again: what is there stays, and what is missing is added"
        ),
        (Some(why), false) => bus::stderr_line!(
            "volume-loader: {path}: NOT ALL IS KEPT: {why}. {counts}. What was there before stays as it was"
        ),
    }
    is_readable && came.lacking.is_none()
}
