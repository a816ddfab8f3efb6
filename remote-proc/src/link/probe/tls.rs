//! The handshake of a probe.

use std::io::{self, Read};
use std::net::{SocketAddr, TcpStream};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use rustls::client::WebPkiServerVerifier;
use rustls::client::danger::{HandshakeSignatureValid, ServerCertVerified, ServerCertVerifier};
use rustls::crypto::{CryptoProvider, ring};
use rustls::pki_types::{CertificateDer, ServerName, UnixTime};
use rustls::version::TLS13;
use rustls::{
    AlertDescription, CertificateError, ClientConfig, ClientConnection, DigitallySignedStruct, Error, SignatureScheme,
};
use time::OffsetDateTime;

use super::{LIMIT, ProbeError};
use crate::link::keys::read::{Shown, shown};
use crate::link::keys::{Keys, Side};

/// By TLS 1.3 a peer looks at our certificate after our handshake is over; for so long its word is waited for.
const LAST_WORD: Duration = Duration::from_millis(150);

/// Makes the handshake over a connection that stands, and takes leave.
pub(super) fn greet(mut stream: TcpStream, at: SocketAddr, host: &str, keys: &Keys) -> Result<(), ProbeError> {
    let broken = |error: &dyn ToString| ProbeError::Handshake {
        at,
        reason: error.to_string(),
    };
    let (config, seen) = config(keys).map_err(|error| broken(&error))?;
    let name = ServerName::try_from(host.to_owned()).map_err(|error| broken(&error))?;
    let mut tls = ClientConnection::new(Arc::new(config), name).map_err(|error| broken(&error))?;
    let limits = stream
        .set_read_timeout(Some(LIMIT))
        .and_then(|()| stream.set_write_timeout(Some(LIMIT)));
    limits.map_err(|error| broken(&error))?;
    let mut first = First::default();
    let shaken = shake(&mut tls, &mut stream, &mut first);
    let peer = seen.take();
    let told = Told {
        at,
        host,
        keys,
        peer: peer.as_ref(),
        first: &first,
    };
    shaken.map_err(|failure| told.failure(failure))?;
    let found = peer.as_ref().map(|peer| peer.name.clone()).unwrap_or_default();
    if found != Side::Sender.common_name() {
        return Err(ProbeError::NoSender { at, found });
    }
    last_word(&mut tls, &mut stream).map_err(|failure| told.failure(failure))?;
    tls.send_close_notify();
    // It answered all that was asked; a connection that breaks now says nothing of the next.
    let _ = tls.write_tls(&mut stream);
    Ok(())
}

enum Failure {
    /// The connection ended or said nothing.
    Io(io::Error),
    /// What came was not what should.
    Tls(Error),
}

impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

/// The first bytes of the peer, by which something else than TLS is told.
#[derive(Default)]
struct First(Vec<u8>);

fn shake(tls: &mut ClientConnection, stream: &mut TcpStream, first: &mut First) -> Result<(), Failure> {
    while tls.is_handshaking() {
        while tls.wants_write() {
            tls.write_tls(stream)?;
        }
        if tls.is_handshaking() {
            take(tls, stream, first)?;
        }
    }
    while tls.wants_write() {
        tls.write_tls(stream)?;
    }
    Ok(())
}

/// Reads what there is.
fn take(tls: &mut ClientConnection, stream: &mut TcpStream, first: &mut First) -> Result<(), Failure> {
    let mut bytes = [0; 4096];
    let count = stream.read(&mut bytes)?;
    if count == 0 {
        return Err(io::Error::from(io::ErrorKind::UnexpectedEof).into());
    }
    let room = 24_usize.saturating_sub(first.0.len());
    first.0.extend(bytes.iter().take(count.min(room)));
    let mut rest = bytes.get(..count).unwrap_or_default();
    while !rest.is_empty() {
        tls.read_tls(&mut rest)?;
        if let Err(error) = tls.process_new_packets() {
            // So that the peer hears why as well.
            let _ = tls.write_tls(stream);
            return Err(Failure::Tls(error));
        }
    }
    Ok(())
}

/// Waits for the alert of a peer that refuses our certificate. One that takes it sends tickets for the next handshake, or nothing.
fn last_word(tls: &mut ClientConnection, stream: &mut TcpStream) -> Result<(), Failure> {
    stream.set_read_timeout(Some(LAST_WORD))?;
    match take(tls, stream, &mut First::default()) {
        Err(Failure::Io(error)) if matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut) => {
            Ok(())
        }
        told => told,
    }
}

/// What is known when a handshake fails.
struct Told<'a> {
    at: SocketAddr,
    host: &'a str,
    keys: &'a Keys,
    peer: Option<&'a Shown>,
    first: &'a First,
}

impl Told<'_> {
    fn failure(&self, failure: Failure) -> ProbeError {
        let at = self.at;
        match failure {
            Failure::Tls(Error::InvalidCertificate(error)) => self.certificate(&error),
            Failure::Tls(Error::AlertReceived(alert)) if is_of_certificate(alert) => {
                let authority = self.keys.authority_name().to_owned();
                ProbeError::Refused {
                    at,
                    authority,
                    alert: format!("{alert:?}"),
                }
            }
            Failure::Tls(Error::InvalidMessage(_)) if !self.is_tls() => ProbeError::NotTls {
                at,
                found: format!("it answers `{}`", self.first.0.escape_ascii()),
            },
            Failure::Tls(error) => ProbeError::Handshake {
                at,
                reason: error.to_string(),
            },
            Failure::Io(_) if self.first.0.is_empty() => ProbeError::NotTls {
                at,
                found: "it takes the connection and answers nothing".to_owned(),
            },
            Failure::Io(error) => ProbeError::Handshake {
                at,
                reason: error.to_string(),
            },
        }
    }

    /// The first byte of TLS is the kind of a record.
    fn is_tls(&self) -> bool {
        matches!(self.first.0.first(), Some(20..=24))
    }

    fn certificate(&self, error: &CertificateError) -> ProbeError {
        let at = self.at;
        let Some(peer) = self.peer else {
            return ProbeError::Handshake {
                at,
                reason: format!("the peer's certificate: {error}"),
            };
        };
        let (name, now) = (peer.name.clone(), OffsetDateTime::now_utc());
        match error {
            CertificateError::Expired | CertificateError::ExpiredContext { .. } => ProbeError::Expired {
                at,
                name,
                not_after: peer.not_after,
                now,
            },
            CertificateError::NotValidYet | CertificateError::NotValidYetContext { .. } => ProbeError::NotYet {
                at,
                name,
                not_before: peer.not_before,
                now,
            },
            CertificateError::UnknownIssuer | CertificateError::BadSignature => {
                let ours = self.keys.authority_name().to_owned();
                ProbeError::Authority {
                    at,
                    name,
                    found: peer.issuer.clone(),
                    ours,
                }
            }
            CertificateError::NotValidForName | CertificateError::NotValidForNameContext { .. } => ProbeError::Host {
                at,
                asked: self.host.to_owned(),
                hosts: peer.hosts.clone(),
            },
            CertificateError::InvalidPurpose | CertificateError::InvalidPurposeContext { .. } => {
                ProbeError::NoSender { at, found: name }
            }
            other => ProbeError::Handshake {
                at,
                reason: format!("the certificate of {name}: {other}"),
            },
        }
    }
}

const fn is_of_certificate(alert: AlertDescription) -> bool {
    use AlertDescription as Alert;
    matches!(
        alert,
        Alert::BadCertificate
            | Alert::UnsupportedCertificate
            | Alert::CertificateRevoked
            | Alert::CertificateExpired
            | Alert::CertificateUnknown
            | Alert::UnknownCA
            | Alert::AccessDenied
            | Alert::DecryptError
            | Alert::CertificateRequired
    )
}

/// The peer's certificate, whether it was taken or not.
#[derive(Debug, Clone, Default)]
struct Seen(Arc<Mutex<Option<Shown>>>);

impl Seen {
    fn take(&self) -> Option<Shown> {
        self.0.lock().ok().and_then(|mut seen| seen.take())
    }
}

fn config(keys: &Keys) -> Result<(ClientConfig, Seen), Error> {
    let handshake = keys.for_handshake();
    let provider = Arc::new(ring::default_provider());
    let seen = Seen::default();
    let verifier = Noting::new(handshake.roots, Arc::clone(&provider), seen.clone())?;
    // "Dangerous" is any verifier of one's own; this one notes what it sees and leaves the decision to the usual one.
    let config = ClientConfig::builder_with_provider(provider)
        .with_protocol_versions(&[&TLS13])?
        .dangerous()
        .with_custom_certificate_verifier(Arc::new(verifier))
        .with_client_auth_cert(handshake.chain, handshake.key)?;
    Ok((config, seen))
}

/// The usual verifier, that trusts the authority alone, and a note of what it was shown.
#[derive(Debug)]
struct Noting {
    usual: Arc<WebPkiServerVerifier>,
    seen: Seen,
}

impl Noting {
    fn new(roots: rustls::RootCertStore, provider: Arc<CryptoProvider>, seen: Seen) -> Result<Self, Error> {
        let usual = WebPkiServerVerifier::builder_with_provider(roots.into(), provider).build();
        let usual = usual.map_err(|error| Error::General(error.to_string()))?;
        Ok(Self { usual, seen })
    }
}

impl ServerCertVerifier for Noting {
    fn verify_server_cert(
        &self,
        end: &CertificateDer<'_>,
        between: &[CertificateDer<'_>],
        name: &ServerName<'_>,
        ocsp: &[u8],
        now: UnixTime,
    ) -> Result<ServerCertVerified, Error> {
        if let Ok(mut seen) = self.seen.0.lock() {
            *seen = shown(end);
        }
        self.usual.verify_server_cert(end, between, name, ocsp, now)
    }

    fn verify_tls12_signature(
        &self,
        message: &[u8],
        certificate: &CertificateDer<'_>,
        signed: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, Error> {
        self.usual.verify_tls12_signature(message, certificate, signed)
    }

    fn verify_tls13_signature(
        &self,
        message: &[u8],
        certificate: &CertificateDer<'_>,
        signed: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, Error> {
        self.usual.verify_tls13_signature(message, certificate, signed)
    }

    fn supported_verify_schemes(&self) -> Vec<SignatureScheme> {
        self.usual.supported_verify_schemes()
    }
}
