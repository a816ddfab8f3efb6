//! Files of the oracle.

use std::io::Read;
use std::path::PathBuf;

use geometry::Ct;
use serde_json::Value;
use surface_registration::Surface;

/// Corners and triangles.
pub(crate) type Triangles = (Vec<[f64; 3]>, Vec<[u32; 3]>);

/// The folder of the oracle; `None`, with the reason printed, where it is not there.
pub(crate) fn folder() -> Option<PathBuf> {
    let told = std::env::var_os("TROCAR_SHARED").map(PathBuf::from);
    let beside = || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared"));
    let folder = told.unwrap_or_else(beside).join("oracles/surface");
    if folder.join("truth.json").is_file() {
        return Some(folder);
    }
    eprintln!(
        "skipped: {} is not there (TROCAR_SHARED names the folder)",
        folder.display()
    );
    None
}

/// A bone's corners and triangles.
pub(crate) fn bone(name: &str) -> Option<Triangles> {
    let bytes = std::fs::read(folder()?.join("bones").join(format!("{name}.npz"))).unwrap();
    let corners = array(&bytes, "vertices_mm.npy");
    let corners: Vec<f64> = corners
        .chunks_exact(4)
        .map(|b| f32::from_le_bytes(b.try_into().unwrap()).into())
        .collect();
    let triangles = array(&bytes, "triangles.npy");
    let triangles: Vec<u32> = triangles
        .chunks_exact(4)
        .map(|b| u32::from_le_bytes(b.try_into().unwrap()))
        .collect();
    Some((
        corners.chunks_exact(3).map(|c| c.try_into().unwrap()).collect(),
        triangles.chunks_exact(3).map(|c| c.try_into().unwrap()).collect(),
    ))
}

/// A bone as a surface.
pub(crate) fn surface(name: &str) -> Option<Surface<Ct>> {
    let (corners, triangles) = bone(name)?;
    Some(Surface::new(&corners, &triangles).unwrap())
}

/// The numbers of an array of NumPy's `savez_compressed`: the entry's local header says how long its name is, the central directory how
/// many bytes it has.
fn array(zip: &[u8], name: &str) -> Vec<u8> {
    let u16_at = |i: usize| usize::from(u16::from_le_bytes(zip[i..i + 2].try_into().unwrap()));
    let u32_at = |i: usize| u32::from_le_bytes(zip[i..i + 4].try_into().unwrap()) as usize;
    let end = zip.windows(4).rposition(|w| w == b"PK\x05\x06").unwrap();
    let mut entry = u32_at(end + 16);
    loop {
        assert_eq!(&zip[entry..entry + 4], b"PK\x01\x02", "{name} is not in the file");
        let length = u16_at(entry + 28);
        if &zip[entry + 46..entry + 46 + length] == name.as_bytes() {
            break;
        }
        entry += 46 + length + u16_at(entry + 30) + u16_at(entry + 32);
    }
    let (packed, local) = (u32_at(entry + 20), u32_at(entry + 42));
    let first = local + 30 + u16_at(local + 26) + u16_at(local + 28);
    let mut bytes = Vec::new();
    flate2::read::DeflateDecoder::new(&zip[first..first + packed])
        .read_to_end(&mut bytes)
        .unwrap();
    let header = usize::from(u16::from_le_bytes(bytes[8..10].try_into().unwrap()));
    bytes.split_off(10 + header)
}

/// All problems, and their truths by id.
pub(crate) fn problems() -> Option<(Vec<Value>, Value)> {
    let folder = folder()?;
    let read = |name: &str| -> Value { serde_json::from_slice(&std::fs::read(folder.join(name)).unwrap()).unwrap() };
    let problems = read("problems.json")["problems"].as_array().unwrap().clone();
    Some((problems, read("truth.json")))
}
