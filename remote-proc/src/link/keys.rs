//! The keys of a link: a private authority, made for one sender and its receivers, and a certificate of each side that it signed.
//!
//! A folder of keys holds `authority.pem` and, of the side that runs there, `sender.pem` with `sender.key` or `receiver.pem` with
//! `receiver.key`. The common name in a certificate says which side it may be; `authority.key` can sign more of them and is needed by
//! neither side.

use std::fmt;
use std::path::{Path, PathBuf};

use rustls::RootCertStore;
use rustls::pki_types::{CertificateDer, PrivateKeyDer};
use time::OffsetDateTime;

pub mod load;
pub mod make;
pub mod read;

pub use load::LoadError;
pub use make::{Made, MakeError, make};

/// The file of the authority's certificate.
pub const AUTHORITY: &str = "authority.pem";
/// The file of the authority's private key, which neither side needs.
pub const AUTHORITY_KEY: &str = "authority.key";

/// Which end of the link.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Beside the run: it listens.
    Sender,
    /// The other machine: it connects.
    Receiver,
}

impl Side {
    /// The common name in its certificate, by which the peer knows what it may do.
    pub const fn common_name(self) -> &'static str {
        match self {
            Self::Sender => "trocar-sender",
            Self::Receiver => "trocar-receiver",
        }
    }

    /// The file of its certificate.
    pub fn certificate_file(self, folder: &Path) -> PathBuf {
        folder.join(format!("{self}.pem"))
    }

    /// The file of its private key.
    pub fn key_file(self, folder: &Path) -> PathBuf {
        folder.join(format!("{self}.key"))
    }
}

impl fmt::Display for Side {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Sender => "sender",
            Self::Receiver => "receiver",
        })
    }
}

/// One side's keys, read and checked: the certificate is valid now, of this authority, for this side, and of this private key.
pub struct Keys {
    side: Side,
    authority_name: String,
    authority: CertificateDer<'static>,
    certificate: CertificateDer<'static>,
    key: PrivateKeyDer<'static>,
    /// In PEM, for zenoh: authority, certificate, private key.
    pem: [String; 3],
    not_after: OffsetDateTime,
}

impl Keys {
    /// Reads one side's keys from a folder and checks them, so that what is wrong has a name before anybody is dialled.
    ///
    /// # Errors
    /// Each variant of [`LoadError`].
    pub fn load(folder: &Path, side: Side) -> Result<Self, LoadError> {
        load::load(folder, side)
    }

    /// Whose they are.
    pub const fn side(&self) -> Side {
        self.side
    }

    /// The common name in the certificate: [`Side::common_name`].
    pub const fn name(&self) -> &'static str {
        self.side.common_name()
    }

    /// The common name of the authority, which differs between any two that [`make()`] made.
    pub fn authority_name(&self) -> &str {
        &self.authority_name
    }

    /// The authority's certificate, as PEM.
    pub fn authority(&self) -> &str {
        &self.pem[0]
    }

    /// The certificate, as PEM.
    pub fn certificate(&self) -> &str {
        &self.pem[1]
    }

    /// The private key, as PEM.
    pub fn key(&self) -> &str {
        &self.pem[2]
    }

    /// When the certificate or its authority ends, whichever is first. A link that stands then is not cut; the next one is refused.
    pub const fn not_after(&self) -> OffsetDateTime {
        self.not_after
    }

    /// Whole days that are left until then, below zero where it is past.
    pub fn days_left(&self) -> i64 {
        (self.not_after - OffsetDateTime::now_utc()).whole_days()
    }

    /// For a handshake: whom to trust, and what to show.
    pub(crate) fn for_handshake(&self) -> Handshake {
        let mut roots = RootCertStore::empty();
        // Read and checked before, so that one is always taken.
        roots.add_parsable_certificates([self.authority.clone()]);
        let chain = vec![self.certificate.clone()];
        Handshake {
            roots,
            chain,
            key: self.key.clone_key(),
        }
    }
}

/// What a handshake needs of the keys.
pub(crate) struct Handshake {
    /// The authority alone.
    pub(crate) roots: RootCertStore,
    /// The own certificate.
    pub(crate) chain: Vec<CertificateDer<'static>>,
    /// Its private key.
    pub(crate) key: PrivateKeyDer<'static>,
}

/// Without the private key.
impl fmt::Debug for Keys {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut keys = f.debug_struct("Keys");
        keys.field("name", &self.name())
            .field("authority", &self.authority_name);
        keys.field("not_after", &self.not_after).finish_non_exhaustive()
    }
}
