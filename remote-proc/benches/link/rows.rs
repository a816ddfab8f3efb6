//! What is measured.

use std::time::Duration;

/// A row of the table.
pub(crate) struct Row {
    pub(crate) name: &'static str,
    pub(crate) hz: f64,
    pub(crate) seconds: f64,
    pub(crate) receivers: usize,
    /// Half a round trip.
    pub(crate) delay: Option<Duration>,
    /// What the added latency must keep within, ms.
    pub(crate) must_ms: f64,
    pub(crate) tls: bool,
    pub(crate) dims: [u32; 3],
}

const PLAIN: Row = Row {
    name: "",
    hz: 60.0,
    seconds: 20.0,
    receivers: 1,
    delay: None,
    must_ms: 1.0,
    tls: false,
    dims: [64, 64, 64],
};

pub(crate) fn rows() -> Vec<Row> {
    vec![
        Row {
            name: "tcp 60 Hz",
            ..PLAIN
        },
        Row {
            name: "tls 60 Hz",
            tls: true,
            ..PLAIN
        },
        Row {
            name: "tls 500 Hz",
            hz: 500.0,
            seconds: 10.0,
            tls: true,
            ..PLAIN
        },
        Row {
            name: "tls 60 Hz, 5 ms round trip",
            tls: true,
            delay: Some(Duration::from_micros(2500)),
            must_ms: 5.0,
            ..PLAIN
        },
        Row {
            name: "tls 60 Hz, 2 receivers",
            tls: true,
            receivers: 2,
            ..PLAIN
        },
        Row {
            name: "tls 60 Hz, 4 receivers",
            tls: true,
            receivers: 4,
            ..PLAIN
        },
        Row {
            name: "tls 60 Hz, 8 receivers",
            tls: true,
            receivers: 8,
            ..PLAIN
        },
        Row {
            name: "tls 500 Hz, 8 receivers",
            hz: 500.0,
            seconds: 10.0,
            tls: true,
            receivers: 8,
            ..PLAIN
        },
        Row {
            name: "tls 60 Hz, volume of 210 MB",
            seconds: 5.0,
            tls: true,
            dims: [512, 512, 400],
            ..PLAIN
        },
    ]
}
