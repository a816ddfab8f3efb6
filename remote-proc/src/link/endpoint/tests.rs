use super::*;

#[test]
fn what_is_written_is_given_on_without_options() {
    for (text, given) in [
        ("tls/nav-1.hospital.example:7447", "tls/nav-1.hospital.example:7447"),
        ("tls/NAV-1:1", "tls/nav-1:1"),
        ("tls/192.168.0.30:65535", "tls/192.168.0.30:65535"),
        ("tcp/127.0.0.1:7447", "tcp/127.0.0.1:7447"),
        ("tcp/127.9.8.7:7447", "tcp/127.9.8.7:7447"),
        ("tcp/[::1]:7447", "tcp/[::1]:7447"),
        ("tcp/localhost:7447", "tcp/127.0.0.1:7447"),
        ("tls/localhost:7447", "tls/localhost:7447"),
    ] {
        for read in [Endpoint::listen, Endpoint::connect] {
            assert_eq!(read(text).unwrap().to_string(), given);
        }
    }
    for text in ["tls/0.0.0.0:7447", "tls/[::]:0", "tcp/127.0.0.1:0"] {
        assert_eq!(Endpoint::listen(text).unwrap().to_string(), text);
    }
}

#[test]
fn plain_tcp_off_loopback_is_refused_with_what_to_do() {
    for host in [
        "0.0.0.0",
        "192.168.0.30",
        "nav-1",
        "128.0.0.1",
        "[::]",
        "[::ffff:127.0.0.1]",
        "localhost.example",
    ] {
        let said = Endpoint::listen(&format!("tcp/{host}:7447")).unwrap_err();
        assert!(matches!(said, EndpointError::Exposed { .. }), "{said}");
        let said = said.to_string();
        assert!(
            said.contains("remote-proc keys") && said.contains("write tls/"),
            "{said}"
        );
    }
}

#[test]
fn what_is_no_endpoint_is_refused_by_name() {
    let listen = |text: &str| Endpoint::listen(text).unwrap_err();
    let connect = |text: &str| Endpoint::connect(text).unwrap_err();
    for text in [
        "tls/nav:7447#verify_name_on_connect=false",
        "tcp/127.0.0.1:7447#iface=eth0",
        "tls/nav:7447?rel=0",
        "tls/nav:7447;enable_mtls=false",
    ] {
        assert!(matches!(listen(text), EndpointError::Options { .. }), "{text}");
    }
    for text in ["", "nav:7447", "tls/nav", "tls"] {
        assert!(matches!(listen(text), EndpointError::Form { .. }), "{text}");
    }
    for text in ["udp/127.0.0.1:7447", "quic/nav:7447", "TLS/nav:7447", "/nav:7447"] {
        assert!(matches!(listen(text), EndpointError::Transport { .. }), "{text}");
    }
    for host in [
        "",
        " nav",
        "nav 1",
        "a/b",
        "*.nav",
        "127.1",
        "2130706433",
        "0x7f.1",
        "::1",
        "[nav]",
        "[::1",
        "nav,tcp",
        "-",
    ] {
        let text = format!("tls/{host}:7447");
        assert!(
            matches!(listen(&text), EndpointError::Host { .. }),
            "{text}: {}",
            listen(&text)
        );
    }
    for port in ["", "65536", "-1", "+1", "http", "7447/"] {
        let text = format!("tls/nav:{port}");
        assert!(matches!(listen(&text), EndpointError::Port { .. }), "{text}");
    }
    assert!(matches!(connect("tls/nav:0"), EndpointError::Port { least: 1, .. }));
    assert!(matches!(connect("tls/[fe80::1]:7447"), EndpointError::Ipv6 { .. }));
    assert!(matches!(connect("tls/0.0.0.0:7447"), EndpointError::Unspecified { .. }));
}
