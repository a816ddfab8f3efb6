//! Reading keys and checking all that a peer will check, so that what is wrong is told by name and not as a failed connection.

use std::io::Read;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use rustls::RootCertStore;
use rustls::client::verify_server_cert_signed_by_trust_anchor;
use rustls::crypto::ring;
use rustls::pki_types::pem::PemObject;
use rustls::pki_types::{CertificateDer, PrivateKeyDer, UnixTime};
use rustls::server::{ParsedCertificate, WebPkiClientVerifier};
use rustls::sign::CertifiedKey;
use scene::file::OpenError;
use time::OffsetDateTime;

use super::read::{Shown, date, shown};
use super::{AUTHORITY, Keys, Side};

/// The longest file of keys that is read, in bytes.
const LONGEST: u64 = 1 << 16;

/// Why keys are not used.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// A file is missing or cannot be read.
    #[error("{}: {source}; `remote-proc keys` makes it", path.display())]
    Open {
        /// The file.
        path: PathBuf,
        /// Why.
        source: OpenError,
    },
    /// Others may read a private key, or write what says whom to trust.
    #[error("{} has mode {found:04o}: {harm}; chmod 600 it", path.display())]
    Mode {
        /// The file.
        path: PathBuf,
        /// Its mode.
        found: u32,
        /// What others may do.
        harm: &'static str,
    },
    /// The file does not hold what it should.
    #[error("{}: {found}, expected one {expected} as PEM", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// What it should hold.
        expected: &'static str,
        /// What it holds.
        found: String,
    },
    /// The time of a certificate is over.
    #[error("{}: the certificate of {name} ended {}, and now it is {}; make new keys", path.display(), date(*not_after), date(*now))]
    Expired {
        /// The file.
        path: PathBuf,
        /// Its common name.
        name: String,
        /// When it ended.
        not_after: OffsetDateTime,
        /// This machine's clock.
        now: OffsetDateTime,
    },
    /// The time of a certificate has not begun.
    #[error("{}: the certificate of {name} begins {}, and now it is {}; set this machine's clock", path.display(), date(*not_before), date(*now))]
    NotYet {
        /// The file.
        path: PathBuf,
        /// Its common name.
        name: String,
        /// When it begins.
        not_before: OffsetDateTime,
        /// This machine's clock.
        now: OffsetDateTime,
    },
    /// The certificate is the other side's, or of something else.
    #[error("{}: the certificate is of `{found}`, expected `{expected}`", path.display())]
    Name {
        /// The file.
        path: PathBuf,
        /// Its common name.
        found: String,
        /// This side's.
        expected: &'static str,
    },
    /// Another authority signed the certificate.
    #[error("{}: signed by `{issuer}`, and {AUTHORITY} beside it is `{authority}`: files of two sets of keys lie together", path.display())]
    Authority {
        /// The file.
        path: PathBuf,
        /// Who signed it.
        issuer: String,
        /// Who is trusted.
        authority: String,
    },
    /// A peer would refuse it for another reason.
    #[error("{}: a peer would refuse this certificate: {source}", path.display())]
    Refused {
        /// The file.
        path: PathBuf,
        /// Why.
        source: rustls::Error,
    },
    /// The private key is of another certificate.
    #[error("{} is not the private key of {}: files of two sets of keys lie together", key.display(), certificate.display())]
    KeyOfAnother {
        /// The private key.
        key: PathBuf,
        /// The certificate.
        certificate: PathBuf,
    },
}

pub(super) fn load(folder: &Path, side: Side) -> Result<Keys, LoadError> {
    let paths = [
        folder.join(AUTHORITY),
        side.certificate_file(folder),
        side.key_file(folder),
    ];
    let [of_authority, of_certificate, of_key] = &paths;
    let (authority_pem, authority) = certificate(of_authority)?;
    let (certificate_pem, certificate) = certificate(of_certificate)?;
    let key_pem = read(of_key, 0o077, "others may use this key")?;
    let key = PrivateKeyDer::from_pem_slice(key_pem.as_bytes())
        .map_err(|error| content(of_key, "private key", format!("{error:?}")))?;
    let now = OffsetDateTime::now_utc();
    let (trusted, own) = (about(of_authority, &authority)?, about(of_certificate, &certificate)?);
    if own.name != side.common_name() {
        let expected = side.common_name();
        return Err(LoadError::Name {
            path: of_certificate.clone(),
            found: own.name,
            expected,
        });
    }
    in_time(of_authority, &trusted, now)?;
    in_time(of_certificate, &own, now)?;
    let by_authority = verify(side, &authority, &certificate);
    by_authority.map_err(|error| refusal(of_certificate, error, &own, &trusted))?;
    belongs(&certificate, &key, of_certificate, of_key)?;
    Ok(Keys {
        side,
        authority_name: trusted.name,
        authority,
        certificate,
        key,
        pem: [authority_pem, certificate_pem, key_pem],
        not_after: own.not_after.min(trusted.not_after),
    })
}

fn content(path: &Path, expected: &'static str, found: String) -> LoadError {
    LoadError::Content {
        path: path.to_owned(),
        expected,
        found,
    }
}

/// The text of a file whose mode leaves out `forbidden`.
fn read(path: &Path, forbidden: u32, harm: &'static str) -> Result<String, LoadError> {
    let at = |source: OpenError| LoadError::Open {
        path: path.to_owned(),
        source,
    };
    let (file, about) = scene::file::open(path).map_err(at)?;
    let found = about.mode() & 0o7777;
    if found & forbidden != 0 {
        return Err(LoadError::Mode {
            path: path.to_owned(),
            found,
            harm,
        });
    }
    if about.len() > LONGEST {
        return Err(at(OpenError::TooLong {
            found: about.len(),
            most: LONGEST,
        }));
    }
    let mut text = String::new();
    file.take(LONGEST)
        .read_to_string(&mut text)
        .map_err(|error| at(error.into()))?;
    Ok(text)
}

/// The one certificate in a file: a second authority would be trusted without being named.
fn certificate(path: &Path) -> Result<(String, CertificateDer<'static>), LoadError> {
    let pem = read(path, 0o022, "others may exchange it")?;
    let all: Result<Vec<_>, _> = CertificateDer::pem_slice_iter(pem.as_bytes()).collect();
    let mut all = all.map_err(|error| content(path, "certificate", format!("{error:?}")))?;
    match (all.pop(), all.len()) {
        (Some(one), 0) => Ok((pem, one)),
        (Some(_), more) => Err(content(path, "certificate", format!("{} certificates", more + 1))),
        (None, _) => Err(content(path, "certificate", "no certificate".to_owned())),
    }
}

fn about(path: &Path, certificate: &CertificateDer<'_>) -> Result<Shown, LoadError> {
    shown(certificate).ok_or_else(|| content(path, "certificate", "PEM of something else".to_owned()))
}

fn in_time(path: &Path, of: &Shown, now: OffsetDateTime) -> Result<(), LoadError> {
    let (path, name) = (path.to_owned(), of.name.clone());
    if now < of.not_before {
        return Err(LoadError::NotYet {
            path,
            name,
            not_before: of.not_before,
            now,
        });
    }
    if now > of.not_after {
        return Err(LoadError::Expired {
            path,
            name,
            not_after: of.not_after,
            now,
        });
    }
    Ok(())
}

/// As the peer will verify it, but for the host's name.
fn verify(
    side: Side,
    authority: &CertificateDer<'static>,
    certificate: &CertificateDer<'_>,
) -> Result<(), rustls::Error> {
    let provider = ring::default_provider();
    let mut roots = RootCertStore::empty();
    roots.add(authority.clone())?;
    let now = UnixTime::now();
    match side {
        Side::Sender => {
            let parsed = ParsedCertificate::try_from(certificate)?;
            let algorithms = provider.signature_verification_algorithms.all;
            verify_server_cert_signed_by_trust_anchor(&parsed, &roots, &[], now, algorithms)
        }
        Side::Receiver => {
            let verifier = WebPkiClientVerifier::builder_with_provider(roots.into(), provider.into()).build();
            let verifier = verifier.map_err(|error| rustls::Error::General(error.to_string()))?;
            verifier.verify_client_cert(certificate, &[], now).map(drop)
        }
    }
}

fn refusal(path: &Path, error: rustls::Error, own: &Shown, trusted: &Shown) -> LoadError {
    use rustls::CertificateError::{BadSignature, UnknownIssuer};
    let path = path.to_owned();
    match error {
        rustls::Error::InvalidCertificate(UnknownIssuer | BadSignature) => {
            let (issuer, authority) = (own.issuer.clone(), trusted.name.clone());
            LoadError::Authority {
                path,
                issuer,
                authority,
            }
        }
        source => LoadError::Refused { path, source },
    }
}

fn belongs(
    certificate: &CertificateDer<'static>,
    key: &PrivateKeyDer<'static>,
    of_certificate: &Path,
    of_key: &Path,
) -> Result<(), LoadError> {
    let both = CertifiedKey::from_der(vec![certificate.clone()], key.clone_key(), &ring::default_provider());
    match both {
        Ok(_) => Ok(()),
        Err(rustls::Error::InconsistentKeys(_)) => Err(LoadError::KeyOfAnother {
            key: of_key.to_owned(),
            certificate: of_certificate.to_owned(),
        }),
        Err(error) => Err(content(of_key, "private key", error.to_string())),
    }
}
