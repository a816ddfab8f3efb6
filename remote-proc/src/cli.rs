//! The command line.

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use bus::process::{Membership, exit};
use clap::{Parser, Subcommand};

use crate::link::keys::{self, AUTHORITY_KEY, Side, read::date};
use crate::link::watch;
use crate::receive::{Receiving, receive};
use crate::send::{Sending, send};

/// Shows a run on a second machine, one way. Trocar is research software and not a medical device.
#[derive(Debug, Parser)]
#[command(
    name = "remote-proc",
    version,
    after_help = "On the machine that navigates:\n  \
    remote-proc keys --out keys --host 10.0.0.5         an authority and two certificates\n  \
    remote-proc send --listen tls/0.0.0.0:7447 --keys keys\n\n\
    On the other one, with authority.pem, receiver.pem and receiver.key of that folder:\n  \
    pilot remote tls/10.0.0.5:7447 --keys keys --window\n\n\
    To try it on one machine: --listen tcp/127.0.0.1:7447, and `pilot remote tcp/127.0.0.1:7447`.\n\n\
    Exit codes: 0 all well; 1 refused or failed."
)]
struct Cli {
    #[command(subcommand)]
    command: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// Makes the keys of a link: a private authority and a certificate of each side.
    ///
    /// Writes authority.pem, authority.key, sender.pem, sender.key, receiver.pem and receiver.key, each for you alone to read, and
    /// replaces nothing. The sender's machine needs authority.pem, sender.pem and sender.key; a receiver's needs authority.pem,
    /// receiver.pem and receiver.key. Whoever has authority.key can make further certificates: keep it off both machines, or delete it.
    Keys {
        /// The folder to write into; made where there is none.
        #[arg(long, value_name = "DIR")]
        out: PathBuf,
        /// A name or address of the sender's machine, as receivers will write it; may be given several times.
        #[arg(long = "host", value_name = "NAME_OR_IP", required = true)]
        hosts: Vec<String>,
        /// How long all of it is valid, in days.
        #[arg(long, value_name = "DAYS", default_value_t = 365)]
        days: u32,
    },
    /// Shows a run of this machine to whoever comes with the right keys, until the run ends.
    Send {
        /// The run.
        #[arg(long, default_value = "default")]
        run: String,
        /// Where receivers come: tls/ADDRESS:PORT, or tcp/127.0.0.1:PORT for this machine alone.
        #[arg(long, default_value = "tcp/127.0.0.1:7447")]
        listen: String,
        /// The folder with this side's keys: authority.pem, sender.pem, sender.key.
        #[arg(long, value_name = "DIR")]
        keys: Option<PathBuf>,
    },
    /// Brings another machine's run onto this machine's bus; started by `pilot remote`.
    Receive {
        /// Where the sender listens.
        #[arg(value_name = "ENDPOINT")]
        endpoint: String,
        /// The folder with this side's keys.
        #[arg(long, value_name = "DIR")]
        keys: Option<PathBuf>,
        /// The run, as `remote-proc facts` names it.
        #[arg(long, value_name = "HEX", value_parser = hexadecimal)]
        session: u64,
        /// The folder of the run here.
        #[arg(long, value_name = "DIR")]
        run_dir: PathBuf,
        /// The pilot that starts this; with it this process ends.
        #[arg(long, value_name = "PID")]
        parent: Option<u32>,
    },
    /// Says what a sender shows, as JSON.
    Facts {
        /// Where it listens.
        #[arg(value_name = "ENDPOINT")]
        endpoint: String,
        /// The folder with this side's keys.
        #[arg(long, value_name = "DIR")]
        keys: Option<PathBuf>,
    },
}

fn hexadecimal(text: &str) -> Result<u64, String> {
    u64::from_str_radix(text, 16).map_err(|_| format!("{text:?} is no number of 64 bits in hexadecimal"))
}

/// The command line, for manual pages and completions.
pub fn command() -> clap::Command {
    <Cli as clap::CommandFactory>::command()
}

/// The binary.
pub fn main() -> ExitCode {
    bus::process::keep_to_oneself();
    match Cli::parse().command {
        Verb::Keys { out, hosts, days } => exit(
            "remote-proc",
            keys::make(&out, &hosts, days).map(|made| say(&words(&made))),
        ),
        Verb::Send { run, listen, keys } => {
            watch::start();
            exit("remote-proc", send(&Sending { run, listen, keys }))
        }
        Verb::Receive {
            endpoint,
            keys,
            session,
            run_dir,
            parent,
        } => {
            let receiving = Receiving {
                endpoint,
                keys,
                session,
            };
            exit("remote-proc", receive(&receiving, &Membership { run_dir, parent }))
        }
        Verb::Facts { endpoint, keys } => exit(
            "remote-proc",
            crate::facts::ask(&endpoint, keys.as_deref()).map(|told| {
                let json = serde_json::to_string_pretty(&told).unwrap_or_default();
                say(&json);
            }),
        ),
    }
}

/// A reader that has closed stdout wants no more.
fn say(text: &str) {
    let _ = writeln!(std::io::stdout(), "{text}");
}

fn words(made: &keys::Made) -> String {
    let mut lines = vec![format!("{} until {}", made.authority, date(made.not_after))];
    lines.extend(made.files.iter().map(|file| format!("  {}", file.display())));
    for side in [Side::Sender, Side::Receiver] {
        lines.push(format!(
            "The {side}'s machine needs authority.pem, {side}.pem and {side}.key."
        ));
    }
    lines.push(format!(
        "{AUTHORITY_KEY} signs further certificates and is needed by neither: keep it off both machines, or delete it."
    ));
    lines.join("\n")
}
