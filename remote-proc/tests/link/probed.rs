//! What a probe says of peers that are no sender.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::Arc;
use std::thread;

use remote_proc::link::endpoint::{Endpoint, Transport};
use remote_proc::link::keys::{Keys, Side};
use remote_proc::link::probe::{ProbeError, probe};
use rustls::crypto::ring;
use rustls::pki_types::pem::PemObject;
use rustls::pki_types::{CertificateDer, PrivateKeyDer};
use rustls::server::WebPkiClientVerifier;
use rustls::{RootCertStore, ServerConfig, ServerConnection};
use tempfile::TempDir;

use crate::support::authority::{Authority, Says};
use crate::support::room::Room;

/// Listens once, and does this with whoever connects.
fn listen(then: impl FnOnce(TcpStream) + Send + 'static) -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    thread::spawn(move || then(listener.accept().unwrap().0));
    port
}

/// A server that shows what `says`, signed by `signer`, and lets in whom `trusted` signed.
fn server(signer: &Authority, says: &Says, trusted: &Authority) -> u16 {
    let (certificate, key) = signer.signs(says);
    let chain = vec![CertificateDer::from_pem_slice(certificate.as_bytes()).unwrap()];
    let key = PrivateKeyDer::from_pem_slice(key.as_bytes()).unwrap();
    let provider = Arc::new(ring::default_provider());
    let mut roots = RootCertStore::empty();
    roots
        .add(CertificateDer::from_pem_slice(trusted.pem().as_bytes()).unwrap())
        .unwrap();
    let clients = WebPkiClientVerifier::builder_with_provider(roots.into(), Arc::clone(&provider))
        .build()
        .unwrap();
    let config = ServerConfig::builder_with_provider(provider)
        .with_safe_default_protocol_versions()
        .unwrap();
    let config = config
        .with_client_cert_verifier(clients)
        .with_single_cert(chain, key)
        .unwrap();
    listen(move |mut stream| {
        let mut tls = ServerConnection::new(Arc::new(config)).unwrap();
        while tls.complete_io(&mut stream).is_ok() && !tls.wants_read() {}
        let _ = tls.complete_io(&mut stream);
        // Until the probe has taken leave.
        let _ = stream.read_to_end(&mut Vec::new());
    })
}

struct Receiver {
    ours: Authority,
    keys: Keys,
    _folder: TempDir,
}

fn receiver() -> Receiver {
    let folder = TempDir::new().unwrap();
    let ours = Authority::new("ours");
    ours.folder(folder.path(), Side::Receiver, &Says::of(Side::Receiver));
    let keys = Keys::load(folder.path(), Side::Receiver).unwrap();
    Receiver {
        ours,
        keys,
        _folder: folder,
    }
}

impl Receiver {
    fn probes(&self, port: u16) -> Result<(), ProbeError> {
        probe(
            &Endpoint::connect(&format!("tls/127.0.0.1:{port}")).unwrap(),
            Some(&self.keys),
        )
    }

    fn told(&self, change: impl Fn(&mut Says)) -> ProbeError {
        let mut says = Says::of(Side::Sender);
        change(&mut says);
        self.probes(server(&self.ours, &says, &self.ours)).unwrap_err()
    }
}

#[test]
fn a_good_sender_is_found_good() {
    let receiver = receiver();
    receiver
        .probes(server(&receiver.ours, &Says::of(Side::Sender), &receiver.ours))
        .unwrap();
}

#[test]
fn a_certificate_that_is_over_early_or_for_another_host_is_told_with_both_sides() {
    let receiver = receiver();
    let said = receiver.told(|says| says.valid = (-20, -10));
    assert!(
        matches!(&said, ProbeError::Expired { name, .. } if name == "trocar-sender"),
        "{said}"
    );
    assert_eq!(said.to_string().matches(" UTC").count(), 2, "{said}");
    let said = receiver.told(|says| says.valid = (10, 20));
    assert!(matches!(&said, ProbeError::NotYet { .. }), "{said}");
    let said = receiver.told(|says| says.hosts = vec!["nav-1".to_owned(), "10.0.0.1".to_owned()]);
    assert!(
        matches!(&said, ProbeError::Host { asked, hosts, .. } if asked == "127.0.0.1" && hosts.len() == 2),
        "{said}"
    );
    assert!(said.to_string().contains("nav-1, 10.0.0.1"), "{said}");
}

#[test]
fn who_is_of_another_authority_or_no_sender_is_told_by_name() {
    let receiver = receiver();
    for name in ["theirs", "ours"] {
        let theirs = Authority::new(name);
        let said = receiver
            .probes(server(&theirs, &Says::of(Side::Sender), &receiver.ours))
            .unwrap_err();
        assert!(
            matches!(&said, ProbeError::Authority { found, ours, .. } if found == name && ours == "ours"),
            "{said}"
        );
    }
    let said = receiver.told(|says| says.name = "trocar-receiver".to_owned());
    assert!(
        matches!(&said, ProbeError::NoSender { found, .. } if found == "trocar-receiver"),
        "{said}"
    );
    let said = receiver.told(|says| says.purposes = Says::of(Side::Receiver).purposes);
    assert!(matches!(&said, ProbeError::NoSender { .. }), "{said}");
}

#[test]
fn a_peer_that_refuses_our_certificate_is_told_after_the_handshake() {
    let receiver = receiver();
    let port = server(&receiver.ours, &Says::of(Side::Sender), &Authority::new("theirs"));
    let said = receiver.probes(port).unwrap_err();
    assert!(
        matches!(&said, ProbeError::Refused { authority, .. } if authority == "ours"),
        "{said}"
    );
    // A sender of another set, as zenoh refuses it.
    let room = Room::open(Transport::Tls);
    let said = probe(&Endpoint::connect(&room.endpoint).unwrap(), Some(&receiver.keys)).unwrap_err();
    assert!(matches!(said, ProbeError::Authority { .. }), "{said}");
}

#[test]
fn what_does_not_speak_tls_is_told() {
    let receiver = receiver();
    let http = listen(|mut stream| {
        let _ = stream.read(&mut [0; 64]);
        let _ = stream.write_all(b"HTTP/1.1 400 Bad Request\r\n\r\n");
        let _ = stream.read_to_end(&mut Vec::new());
    });
    let said = receiver.probes(http).unwrap_err();
    assert!(
        matches!(&said, ProbeError::NotTls { found, .. } if found.contains("HTTP/1.1 400")),
        "{said}"
    );
    let hangs_up = listen(drop);
    assert!(matches!(
        receiver.probes(hangs_up).unwrap_err(),
        ProbeError::NotTls { .. }
    ));
    let silent = listen(|mut stream| drop(stream.read_to_end(&mut Vec::new())));
    assert!(matches!(
        receiver.probes(silent).unwrap_err(),
        ProbeError::NotTls { .. }
    ));
    let room = Room::open(Transport::Tcp);
    let port = room.endpoint.rsplit_once(':').unwrap().1.parse().unwrap();
    let said = receiver.probes(port).unwrap_err();
    assert!(matches!(said, ProbeError::NotTls { .. }), "{said}");
}

#[test]
fn nobody_there_is_told_by_address() {
    let receiver = receiver();
    let free = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = free.local_addr().unwrap().port();
    drop(free);
    assert!(matches!(receiver.probes(port).unwrap_err(), ProbeError::Closed { .. }));
    let plain = Endpoint::connect(&format!("tcp/127.0.0.1:{port}")).unwrap();
    assert!(matches!(probe(&plain, None).unwrap_err(), ProbeError::Closed { .. }));
    let nowhere = Endpoint::connect("tls/no-such-host.invalid:7447").unwrap();
    assert!(matches!(
        probe(&nowhere, Some(&receiver.keys)).unwrap_err(),
        ProbeError::Unknown { .. }
    ));
    let endpoint = Endpoint::connect("tls/127.0.0.1:7447").unwrap();
    assert!(matches!(probe(&endpoint, None).unwrap_err(), ProbeError::NoKeys { .. }));
}
