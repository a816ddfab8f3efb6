//! A simulated device of NDI: the simulated operating room, told to one client at a time in NDI's words over TCP.
//!
//! The device is [`ndi::session::Device`], which bounds what bytes of a client can make it hold; what it measures is a [`Room`].

mod roles;
mod room;
mod served;
mod server;
#[cfg(test)]
mod testing;

use std::io::{self, Write};
use std::net::{SocketAddr, TcpListener, ToSocketAddrs};
use std::path::{Path, PathBuf};

use bus::process::{JoinError, StopFlag};
use ndi::{MOST_MARKERS, Rom, RomError};

pub(crate) use roles::Definitions;
pub use room::{Hands, OpenRoom, Room, RoomFrame, RoomMarker, RoomPose};
use server::Server;

use crate::ndi::{SetUpError, rom};

/// What the command line asks.
#[derive(Debug, clap::Args)]
pub(crate) struct SimulateArgs {
    /// A scene whose tracker.source is "operating-room"
    #[arg(value_name = "SCENE.toml")]
    scene: PathBuf,
    /// Where clients are waited for; port 0 takes a free one, which is printed
    #[arg(long, value_name = "HOST:PORT", default_value = "127.0.0.1:8765")]
    listen: String,
    /// Allow an address that other machines reach: whoever reaches it is served
    #[arg(long)]
    expose: bool,
    /// The definition that stands for the surgeon's tool; without --tool and --patient it is the first that a client loads
    #[arg(long, value_name = "FILE.rom")]
    tool: Option<PathBuf>,
    /// The definition that stands for the marker on the patient; without --tool and --patient it is the second
    #[arg(long, value_name = "FILE.rom")]
    patient: Option<PathBuf>,
    /// Write definitions for this simulated device, tool.rom and patient.rom, into a folder first
    #[arg(long, value_name = "FOLDER")]
    write_tools: Option<PathBuf>,
}

/// Why nothing is simulated.
#[derive(Debug, thiserror::Error)]
pub(crate) enum SimulateError {
    #[error("the simulated operating room of {path}: {source}")]
    Room {
        path: PathBuf,
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    #[error(
        "the device's clock would say {found_s} s at first (tracker.room.localizer.offset_s); on the wire times are 0 or later"
    )]
    NegativeTime { found_s: f64 },
    #[error(transparent)]
    Definition(#[from] SetUpError),
    #[error("--tool and --patient are one definition: nothing would tell the markers apart")]
    SameDefinition,
    #[error("the emitters of {file}: {source}")]
    Written { file: &'static str, source: RomError },
    #[error("{path}: {source}")]
    Write { path: PathBuf, source: io::Error },
    #[error("{path} is there already with other content; it is not written over")]
    Exists { path: PathBuf },
    #[error("--listen {address}: {source}")]
    Listen { address: String, source: io::Error },
    #[error("--listen {address} is {found}, which other machines may reach; --expose allows that")]
    Exposed { address: String, found: SocketAddr },
    #[error(transparent)]
    Signals(#[from] JoinError),
}

/// Serves clients, one after the other, until it is asked to stop.
///
/// # Errors
/// [`SimulateError`]. What a client does is none.
pub(crate) fn simulate(args: &SimulateArgs, hands: Hands) -> Result<(), SimulateError> {
    let stop = StopFlag::install(false)?;
    let room = (hands.room)(&args.scene).map_err(|source| SimulateError::Room {
        path: args.scene.clone(),
        source,
    })?;
    let first_ns = room.frame(0).device_ns;
    if first_ns < 0 {
        return Err(SimulateError::NegativeTime {
            found_s: first_ns as f64 / 1e9,
        });
    }
    if let Some(folder) = &args.write_tools {
        write_tools(room.as_ref(), folder)?;
    }
    let definitions = definitions(args)?;
    let listener = listener(&args.listen, args.expose)?;
    let address = listener.local_addr().map_err(|source| failed(&args.listen, source))?;
    // Who looks on may be gone; the device goes on.
    let _ = writeln!(io::stdout().lock(), "listening on {address}");
    let mut server = Server::new(room, definitions);
    server.serve(&listener, &stop);
    Ok(())
}

fn definitions(args: &SimulateArgs) -> Result<Definitions, SimulateError> {
    let read = |path: &Option<PathBuf>| path.as_deref().map(rom).transpose();
    let definitions = Definitions {
        tool: read(&args.tool)?,
        patient: read(&args.patient)?,
    };
    if definitions.tool.is_some() && definitions.tool == definitions.patient {
        return Err(SimulateError::SameDefinition);
    }
    Ok(definitions)
}

fn failed(address: &str, source: io::Error) -> SimulateError {
    let address = address.to_owned();
    SimulateError::Listen { address, source }
}

fn listener(address: &str, exposed: bool) -> Result<TcpListener, SimulateError> {
    let found: Vec<SocketAddr> = address
        .to_socket_addrs()
        .map_err(|source| failed(address, source))?
        .collect();
    if let Some(found) = found.iter().find(|one| !exposed && !one.ip().is_loopback()) {
        return Err(SimulateError::Exposed {
            address: address.to_owned(),
            found: *found,
        });
    }
    let listener = TcpListener::bind(found.as_slice()).map_err(|source| failed(address, source))?;
    listener
        .set_nonblocking(true)
        .map_err(|source| failed(address, source))?;
    Ok(listener)
}

/// Definitions of the room's markers: of those with more emitters than a tool can have, the first.
fn write_tools(room: &dyn Room, folder: &Path) -> Result<(), SimulateError> {
    let (tool, patient) = room.emitters_mm();
    let files = [
        ("tool.rom", "room tool", Some(tool)),
        ("patient.rom", "room patient", patient),
    ];
    for (file, part, places_mm) in files {
        let Some(places_mm) = places_mm else { continue };
        let places_mm = places_mm.get(..MOST_MARKERS.into()).unwrap_or(&places_mm);
        let rom =
            Rom::simulated("Trocar", part, places_mm).map_err(|source| SimulateError::Written { file, source })?;
        write_new(&folder.join(file), rom.bytes())?;
    }
    Ok(())
}

/// A file that has this content already is left alone.
fn write_new(path: &Path, bytes: &[u8]) -> Result<(), SimulateError> {
    let failed = |source| SimulateError::Write {
        path: path.to_owned(),
        source,
    };
    match std::fs::File::create_new(path) {
        Ok(mut file) => file.write_all(bytes).map_err(failed),
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => match rom(path) {
            Ok(there) if there.bytes() == bytes => Ok(()),
            _ => Err(SimulateError::Exists { path: path.to_owned() }),
        },
        Err(error) => Err(failed(error)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_of_other_machines_needs_a_word_and_loopback_does_not() {
        for address in ["0.0.0.0:0", "[::]:0"] {
            let refused = listener(address, false).unwrap_err().to_string();
            assert!(refused.contains("--expose allows that"), "{refused}");
        }
        assert!(listener("0.0.0.0:0", true).is_ok());
        assert!(
            listener("127.0.0.1:0", false)
                .unwrap()
                .local_addr()
                .unwrap()
                .ip()
                .is_loopback()
        );
        let refused = listener("127.0.0.1", false).unwrap_err().to_string();
        assert!(refused.starts_with("--listen 127.0.0.1: "), "{refused}");
    }

    #[test]
    fn a_file_that_is_there_is_never_written_over() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("tool.rom");
        let bytes = testing::rom("a");
        write_new(&path, bytes.bytes()).unwrap();
        write_new(&path, bytes.bytes()).unwrap();
        let refused = write_new(&path, testing::rom("b").bytes()).unwrap_err();
        assert!(matches!(refused, SimulateError::Exists { .. }), "{refused}");
        assert_eq!(std::fs::read(&path).unwrap(), bytes.bytes());
    }
}
