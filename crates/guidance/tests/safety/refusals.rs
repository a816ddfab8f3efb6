//! Every refusal, by name and with its numbers.

use guidance::safety::{Builder, Input, MAX_BYTES, MAX_SLICE_VOXELS, MapError, Structures, Tube, TubeError};

use crate::support::{Map, point, straight};

#[test]
fn tubes_that_are_none_are_refused() {
    let new = |entry: [f64; 3], tip: [f64; 3], radius| Tube::new(point(entry), point(tip), radius).unwrap_err();
    let (a, b) = ([0.0; 3], [0.0, 0.0, 50.0]);
    assert_eq!(
        new(a, a, 1.0),
        TubeError::EntryIsTip {
            distance_mm: 0.0,
            least_mm: 1e-3
        }
    );
    let what = Input::Radius;
    for found in [0.0, -1.0, 1.0001e4] {
        assert_eq!(
            new(a, b, found),
            TubeError::OutOfRange {
                what,
                found,
                allowed: [0.0, 1e4]
            }
        );
    }
    for found in [f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(new(a, b, found), TubeError::NotFinite { what, found });
        assert_eq!(
            new([0.0, found, 0.0], b, 1.0),
            TubeError::NotFinite {
                what: Input::Entry,
                found
            }
        );
        assert_eq!(
            new(a, [0.0, 0.0, found], 1.0),
            TubeError::NotFinite {
                what: Input::Tip,
                found
            }
        );
    }
    assert!(matches!(
        new(a, b, f64::NAN),
        TubeError::NotFinite {
            what: Input::Radius,
            ..
        }
    ));
    assert!(matches!(
        new(a, [f64::NAN, 0.0, 0.0], 1.0),
        TubeError::NotFinite { what: Input::Tip, .. }
    ));
    let long = new(a, [0.0, 1.0001e4, 0.0], 1.0);
    assert!(
        matches!(
            long,
            TubeError::OutOfRange {
                what: Input::Length,
                ..
            }
        ),
        "{long}"
    );
    let far = new([1.1e6, 0.0, 0.0], [1.1e6, 0.0, 9.0], 1.0);
    assert_eq!(
        far.to_string(),
        "entry of the tube: 1100000 is outside -1000000 to 1000000"
    );
}

#[test]
fn questions_out_of_their_domain_are_refused() {
    let structures = Map::of(straight([4, 4, 4], [1.0; 3]), |_| 1).build();
    let tube = Tube::new(point([0.0; 3]), point([3.0; 3]), 1.0).unwrap();
    for bad in [-1.0, 1.1e4, f64::NAN, f64::INFINITY] {
        assert!(
            structures.clearance(&tube, bad).is_err() && structures.profile(&tube, 5, bad).is_err(),
            "{bad}"
        );
    }
    for bad in [0, 10_001] {
        let error = structures.profile(&tube, bad, 1.0).unwrap_err();
        assert!(
            matches!(
                error,
                TubeError::OutOfRange {
                    what: Input::Sections,
                    ..
                }
            ),
            "{error}"
        );
    }
    for [from, to] in [[-0.1, 1.0], [1.0, 0.5], [0.0, 5.3], [f64::NAN, 1.0], [2.0, 2.0]] {
        assert!(tube.part(from, to).is_err(), "{from} {to}");
    }
    assert_eq!(tube.part(0.0, tube.length_mm()).unwrap().entry(), tube.entry());
}

#[test]
fn maps_that_are_none_are_refused_with_their_numbers() {
    let grid = straight([3, 4, 5], [1.0; 3]);
    assert_eq!(
        Structures::build(&grid, |_, out| out.fill(0)).unwrap_err(),
        MapError::Empty { voxels: 60 }
    );
    let negative = Structures::build(&grid, |z, out| {
        out.fill(1);
        if z == 3 {
            out[2 * 3 + 1] = -7;
        }
    });
    assert_eq!(
        negative.unwrap_err(),
        MapError::Negative {
            voxel: [1, 2, 3],
            found: -7
        }
    );
    // What nobody wrote is refused, and not taken from the slice before.
    let unwritten = Structures::build(&grid, |z, out| {
        if z == 0 {
            out.fill(1)
        }
    })
    .unwrap_err();
    assert_eq!(
        unwritten,
        MapError::Negative {
            voxel: [0, 0, 1],
            found: i16::MIN
        }
    );
}

#[test]
fn slices_of_another_grid_are_refused() {
    let grid = straight([3, 4, 2], [1.0; 3]);
    let mut builder = Builder::new(&grid).unwrap();
    assert_eq!(
        builder.slice(&[1; 11]).unwrap_err(),
        MapError::SliceSize {
            z: 0,
            found: 11,
            expected: 12
        }
    );
    builder.slice(&[1; 12]).unwrap();
    let mut whole = Builder::new(&grid).unwrap();
    (0..2).for_each(|_| whole.slice(&[1; 12]).unwrap());
    assert_eq!(
        whole.slice(&[1; 12]).unwrap_err(),
        MapError::Slices { found: 3, expected: 2 }
    );
    assert_eq!(
        builder.finish().unwrap_err(),
        MapError::Slices { found: 1, expected: 2 }
    );
    let wide = straight([4097, 4096, 1], [1.0; 3]);
    let voxels = 4097 * 4096;
    let error = Builder::new(&wide).err();
    assert_eq!(
        error,
        Some(MapError::SliceTooLarge {
            voxels,
            allowed: MAX_SLICE_VOXELS
        })
    );
}

/// Each voxel another label than its neighbours: 512 blocks of one voxel each in every 8 x 8 x 8.
#[test]
fn a_map_too_ragged_for_its_memory_is_refused() {
    let grid = straight([64, 64, 64], [1.0; 3]);
    let ragged = Map::of(grid, |[x, y, z]| 1 + (x % 8 + 8 * (y % 8) + 64 * (z % 8)) as i16);
    let whole = ragged.build();
    assert_eq!((whole.list().len(), whole.bytes()), (512, 152 << 18));
    let mut builder = Builder::new(&grid).unwrap().limited_to(10 << 20);
    let slices = ragged.labels.chunks_exact(64 * 64);
    let error = slices.map(|slice| builder.slice(slice)).find_map(Result::err).unwrap();
    let MapError::TooLarge {
        allowed,
        boundary,
        slices,
        of,
    } = error
    else {
        panic!("{error}")
    };
    // A layer is eight slices and one above it, 64 blocks of 512 voxels, of 152 bytes each.
    assert!(
        allowed == 10 << 20 && boundary >= (10 << 20) / 152 && slices == 25 && of == 64,
        "{error}"
    );
    // Refused once, refused for good.
    assert_eq!(builder.slice(&ragged.labels[..64 * 64]).unwrap_err(), error);
    assert_eq!(
        builder.finish().unwrap_err(),
        MapError::Slices {
            found: 25,
            expected: 64
        }
    );
    assert_eq!(MAX_BYTES, 1 << 30);
}
