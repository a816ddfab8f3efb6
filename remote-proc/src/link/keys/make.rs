//! Making the keys of a link: `remote-proc keys`.

use std::fs::{self, DirBuilder};
use std::io;
use std::net::IpAddr;
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::path::{Path, PathBuf};

use rcgen::{
    BasicConstraints, CertificateParams, CertifiedIssuer, DnType, ExtendedKeyUsagePurpose, IsCa, KeyPair,
    KeyUsagePurpose,
};
use rustls::pki_types::ServerName;
use scene::file::{Part, PartError};
use time::{Duration, OffsetDateTime};

use super::{AUTHORITY, AUTHORITY_KEY, Side};

/// The fewest and the most days that keys may be valid for.
pub const DAYS: std::ops::RangeInclusive<u32> = 1..=3650;
/// The most hosts in one certificate.
pub const MOST_HOSTS: usize = 64;
/// Valid from so long ago: the clock of the other machine may be behind, and is not set by this one.
const BEFORE: Duration = Duration::DAY;

/// Why no keys are made.
#[derive(Debug, thiserror::Error)]
pub enum MakeError {
    /// Too short or too long.
    #[error("keys for {found} days; allowed are {} to {}", DAYS.start(), DAYS.end())]
    Days {
        /// What was asked for.
        found: u32,
    },
    /// No host, or too many.
    #[error("{found} hosts; the sender's certificate states 1 to {MOST_HOSTS}, as receivers will write them")]
    Hosts {
        /// How many were given.
        found: usize,
    },
    /// This is no host.
    #[error("`{found}` is neither the name of a host nor the address of one; write what receivers will write")]
    Host {
        /// What was given.
        found: String,
    },
    /// Something lies where a file would go.
    #[error("{} is there already, and is not replaced: remove it or write to another folder", path.display())]
    Exists {
        /// The file.
        path: PathBuf,
    },
    /// The folder may be read by others.
    #[error("{} has mode {found:04o}, and others may look into it; chmod 700 it or write to another folder", path.display())]
    Open {
        /// The folder.
        path: PathBuf,
        /// Its mode.
        found: u32,
    },
    /// The folder cannot be made or read.
    #[error("{}: {source}", path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
    /// A file cannot be written.
    #[error("{}: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: PartError,
    },
    /// A certificate could not be made.
    #[error("no certificate could be made: {0}")]
    Certificate(#[from] rcgen::Error),
}

/// What was made.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Made {
    /// The common name of the authority.
    pub authority: String,
    /// The files, in the order in which they were written: the authority, the sender, the receiver, a certificate and a key each.
    pub files: Vec<PathBuf>,
    /// When all of it ends.
    pub not_after: OffsetDateTime,
}

/// Makes an authority and a certificate of each side in `folder`, which is made where there is none. `hosts` are the names or addresses
/// of the sender's machine, as receivers will write them; `days` is how long all of it is valid.
///
/// # Errors
/// Each variant of [`MakeError`]; nothing is written then, unless the disk failed midway.
pub fn make(folder: &Path, hosts: &[String], days: u32) -> Result<Made, MakeError> {
    if !DAYS.contains(&days) {
        return Err(MakeError::Days { found: days });
    }
    if !(1..=MOST_HOSTS).contains(&hosts.len()) {
        return Err(MakeError::Hosts { found: hosts.len() });
    }
    if let Some(host) = hosts.iter().find(|host| !is_host(host)) {
        return Err(MakeError::Host { found: host.clone() });
    }
    let now = OffsetDateTime::now_utc();
    let valid = (now - BEFORE, now + Duration::days(days.into()));
    let authority = authority(valid)?;
    let mut files = vec![
        (folder.join(AUTHORITY), authority.pem()),
        (folder.join(AUTHORITY_KEY), authority.key().serialize_pem()),
    ];
    for (side, hosts) in [(Side::Sender, hosts), (Side::Receiver, &[])] {
        let (certificate, key) = signed(side, hosts, valid, &authority)?;
        files.push((side.certificate_file(folder), certificate));
        files.push((side.key_file(folder), key));
    }
    prepare(folder)?;
    write(&files)?;
    let name = authority_name(authority.key());
    let files = files.into_iter().map(|(path, _)| path).collect();
    Ok(Made {
        authority: name,
        files,
        not_after: valid.1,
    })
}

/// Whether a peer could be asked for by this in a handshake.
fn is_host(host: &str) -> bool {
    match host.parse::<IpAddr>() {
        Ok(ip) => !ip.is_unspecified() && !ip.is_multicast(),
        Err(_) => matches!(ServerName::try_from(host), Ok(ServerName::DnsName(_))),
    }
}

/// Its name is of its key, so that two authorities never have the same.
fn authority_name(key: &KeyPair) -> String {
    let id = CertificateParams::default().key_identifier(key);
    let id: String = id.iter().take(4).map(|byte| format!("{byte:02x}")).collect();
    format!("trocar-authority-{id}")
}

fn authority(valid: (OffsetDateTime, OffsetDateTime)) -> Result<CertifiedIssuer<'static, KeyPair>, rcgen::Error> {
    let key = KeyPair::generate()?;
    let mut params = params(&authority_name(&key), &[], valid)?;
    params.is_ca = IsCa::Ca(BasicConstraints::Constrained(0));
    params.key_usages = vec![KeyUsagePurpose::KeyCertSign, KeyUsagePurpose::CrlSign];
    CertifiedIssuer::self_signed(params, key)
}

/// A certificate of one side and its private key, as PEM.
fn signed(
    side: Side,
    hosts: &[String],
    valid: (OffsetDateTime, OffsetDateTime),
    authority: &CertifiedIssuer<'_, KeyPair>,
) -> Result<(String, String), rcgen::Error> {
    let key = KeyPair::generate()?;
    let mut params = params(side.common_name(), hosts, valid)?;
    params.key_usages = vec![KeyUsagePurpose::DigitalSignature];
    // One purpose each, so that neither side can stand for the other.
    params.extended_key_usages = vec![match side {
        Side::Sender => ExtendedKeyUsagePurpose::ServerAuth,
        Side::Receiver => ExtendedKeyUsagePurpose::ClientAuth,
    }];
    params.use_authority_key_identifier_extension = true;
    let certificate = params.signed_by(&key, authority)?;
    Ok((certificate.pem(), key.serialize_pem()))
}

fn params(
    name: &str,
    hosts: &[String],
    valid: (OffsetDateTime, OffsetDateTime),
) -> Result<CertificateParams, rcgen::Error> {
    let mut params = CertificateParams::new(hosts)?;
    params.distinguished_name = rcgen::DistinguishedName::new();
    params.distinguished_name.push(DnType::CommonName, name);
    (params.not_before, params.not_after) = valid;
    Ok(params)
}

/// Makes the folder where there is none, and refuses one that others may look into.
fn prepare(folder: &Path) -> Result<(), MakeError> {
    let at = |source| MakeError::Folder {
        path: folder.to_owned(),
        source,
    };
    DirBuilder::new()
        .recursive(true)
        .mode(0o700)
        .create(folder)
        .map_err(at)?;
    let found = fs::metadata(folder).map_err(at)?.mode() & 0o777;
    match found & 0o077 {
        0 => Ok(()),
        _ => Err(MakeError::Open {
            path: folder.to_owned(),
            found,
        }),
    }
}

/// Writes all of them or, where anything is in the way, none.
fn write(files: &[(PathBuf, String)]) -> Result<(), MakeError> {
    let at = |path: &Path| {
        let path = path.to_owned();
        move |source: PartError| MakeError::Write { path, source }
    };
    let mut parts = Vec::new();
    for (path, content) in files {
        let mut part = Part::lock(path, 0o600).map_err(at(path))?;
        part.write(content.as_bytes()).map_err(|error| at(path)(error.into()))?;
        parts.push((path, part));
    }
    // Looked for while all are locked, so that two who make keys here at once do not replace one another's.
    for (path, _) in &parts {
        if fs::symlink_metadata(path).is_ok() {
            return Err(MakeError::Exists {
                path: path.to_path_buf(),
            });
        }
    }
    for (path, part) in parts {
        part.rename().map_err(|error| at(path)(error.into()))?;
    }
    Ok(())
}
