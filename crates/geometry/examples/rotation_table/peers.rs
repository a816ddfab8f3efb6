//! What other libraries were measured at, from the file that `rotation_peers.py` writes.

/// One line of the file.
pub(crate) struct Peer {
    /// The conversion as the table names it.
    pub(crate) conversion: String,
    pub(crate) by: String,
    /// Worst errors near 0, mid, near pi, random and of all, ulp.
    pub(crate) errors: [f64; 5],
    /// Time per rotation, ns.
    pub(crate) ns: Option<f64>,
}

/// The lines of the file whose path is the first argument; none without one.
pub(crate) fn load() -> Result<Vec<Peer>, String> {
    let Some(path) = std::env::args().nth(1) else {
        return Ok(Vec::new());
    };
    let text = std::fs::read_to_string(&path).map_err(|e| format!("{path}: {e}"))?;
    let lines = text.lines().enumerate().skip(1);
    lines
        .map(|(n, line)| {
            peer(line).ok_or_else(|| format!("{path}, line {}: not as rotation_peers.py writes it", n + 1))
        })
        .collect()
}

fn peer(line: &str) -> Option<Peer> {
    let words: Vec<&str> = line.split(',').collect();
    let [conversion, by, errors @ .., ns] = &words[..] else {
        return None;
    };
    let errors: Vec<f64> = errors.iter().map(|e| e.parse().ok()).collect::<Option<_>>()?;
    Some(Peer {
        conversion: conversion.replace(" vector part", ", vector part"),
        by: (*by).to_string(),
        errors: errors.try_into().ok()?,
        ns: if ns.is_empty() { None } else { Some(ns.parse().ok()?) },
    })
}

/// The libraries in the file, each once, in order.
pub(crate) fn libraries(peers: &[Peer]) -> Vec<&str> {
    let mut names: Vec<&str> = peers.iter().map(|p| p.by.as_str()).collect();
    names.dedup();
    names
}
