//! Tool definitions before they are written to a device.

use ndi::{PoseError, Rom, RomError, Shape};

use crate::support::{MARKERS, real_roms, rom, rom_bytes, summed};

fn refused(change: impl Fn(&mut Vec<u8>)) -> RomError {
    let mut bytes = rom_bytes(&MARKERS);
    change(&mut bytes);
    Rom::checked(&bytes).unwrap_err()
}

#[test]
fn a_good_definition_is_read_and_cut_into_pieces() {
    let rom = rom();
    assert_eq!(
        (rom.maker.as_str(), rom.part.as_str(), rom.markers_mm.len()),
        ("NDI", "ball", 4)
    );
    assert_eq!(
        (rom.least_markers, rom.most_error_mm, rom.shape),
        (3, 0.75, Shape::Body)
    );
    let pieces: Vec<_> = rom.pieces().collect();
    let addresses: Vec<u16> = pieces.iter().map(|(address, _)| *address).collect();
    assert_eq!(addresses, (0..12).map(|n| n * 64).collect::<Vec<u16>>());
    let whole: Vec<u8> = pieces.iter().flat_map(|(_, piece)| *piece).collect();
    assert_eq!(&whole[..752], rom.bytes());
    assert!(whole[752..].iter().all(|byte| *byte == 0));
}

#[test]
fn what_is_no_definition_is_refused_by_name() {
    assert_eq!(refused(|b| b.truncate(751)), RomError::Length { found: 751 });
    assert_eq!(refused(|b| b.extend([0; 272])), RomError::Length { found: 1024 });
    assert!(matches!(refused(|b| b[0] = b'X'), RomError::Foreign { .. }));
    assert!(matches!(refused(|b| b[100] ^= 1), RomError::Checksum { .. }));
    let summed = |change: fn(&mut Vec<u8>)| {
        refused(|bytes| {
            change(bytes);
            summed(bytes);
        })
    };
    assert_eq!(summed(|b| b[28] = 2), RomError::MarkerCount { found: 2 });
    assert_eq!(summed(|b| b[28] = 21), RomError::MarkerCount { found: 21 });
    assert_eq!(summed(|b| b[32] = 5), RomError::LeastMarkers { found: 5, markers: 4 });
    assert_eq!(summed(|b| b[36..40].fill(0)), RomError::MostError { found_mm: 0.0 });
}

#[test]
fn geometry_that_no_pose_comes_of_is_refused() {
    let nan = rom_bytes(&[[f32::NAN; 3]; 4]);
    let error = Rom::checked(&nan).unwrap_err();
    let expected = PoseError::NotFinite {
        field: "place of a marker",
        value: "NaN",
    };
    assert_eq!(
        error,
        RomError::Number {
            byte: 72,
            error: expected
        }
    );
    let zeros = Rom::checked(&rom_bytes(&[[0.0; 3]; 4])).unwrap_err();
    assert_eq!(
        zeros,
        RomError::Together {
            first: 0,
            second: 1,
            found_mm: 0.0
        }
    );
    let line = rom_bytes(&[[0.0, 0.0, 0.0], [0.0, 0.5, 50.0], [0.0, 0.0, 105.0]]);
    assert!(matches!(Rom::checked(&line), Err(RomError::Collinear { found_mm }) if found_mm < 1.0));
    assert!(matches!(Rom::parse(&line).unwrap().shape, Shape::Line { .. }));
}

#[test]
fn a_definition_that_is_written_is_the_one_that_is_read() {
    let places: Vec<[f64; 3]> = MARKERS.iter().map(|place| place.map(f64::from)).collect();
    let rom = Rom::simulated("a maker of many letters", "ball", &places).unwrap();
    assert_eq!(Rom::checked(rom.bytes()).as_ref(), Ok(&rom));
    assert_eq!(
        (rom.maker.as_str(), rom.part.as_str(), rom.least_markers),
        ("a maker of m", "ball", 3)
    );
    assert_eq!(rom.markers_mm, places);
    let many = vec![[0.0; 3]; 21];
    assert_eq!(
        Rom::simulated("m", "p", &many),
        Err(RomError::MarkerCount { found: 21 })
    );
    let line = [[0.0; 3], [0.0, 0.0, 50.0], [0.0, 0.0, 105.0]];
    assert!(matches!(
        Rom::simulated("m", "p", &line),
        Err(RomError::Collinear { .. })
    ));
}

#[test]
fn every_changed_byte_is_refused() {
    let good = rom_bytes(&MARKERS);
    for at in 0..good.len() {
        let mut bytes = good.clone();
        bytes[at] ^= 0x11;
        assert!(Rom::parse(&bytes).is_err(), "{at}");
    }
}

#[test]
fn real_tools_are_read_and_the_one_on_a_line_is_told() {
    for (name, bytes) in real_roms() {
        let rom = Rom::parse(&bytes).unwrap();
        let is_line = matches!(rom.shape, Shape::Line { .. });
        assert_eq!(is_line, name == "8700248.rom", "{name}");
        assert_eq!(Rom::checked(&bytes).is_ok(), !is_line, "{name}");
    }
}
