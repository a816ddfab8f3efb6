//! Good files of every kind.

use geometry::{Point, Voxel};

use super::*;

fn corner(bytes: &[u8], x: f64, y: f64, z: f64) -> [f64; 3] {
    let source = open_bytes(bytes).unwrap();
    (source.grid().ct_from_voxel() * Point::<Voxel>::new(x, y, z)).mm()
}

#[test]
fn both_byte_orders_plain_and_packed() {
    let want: Vec<i16> = (0..12).collect();
    for big_endian in [false, true] {
        let bytes = Hand::counted(big_endian).bytes;
        for content in [bytes.clone(), gzip(&bytes)] {
            let (voxels, conversion) = read_bytes(&content).unwrap();
            assert_eq!((voxels, conversion), (want.clone(), Conversion::default()));
        }
    }
}

#[test]
fn gzip_in_two_members_is_one_stream() {
    let bytes = Hand::counted(false).bytes;
    let packed = [gzip(&bytes[..360]), gzip(&bytes[360..])].concat();
    assert_eq!(read_bytes(&packed).unwrap().0, (0..12).collect::<Vec<i16>>());
}

#[test]
fn axes_become_lps() {
    let mut hand = Hand::counted(false);
    // RAS: 10 mm right, 20 mm anterior, 30 mm up; steps of 1 mm right, anterior, up.
    hand.f32(292, 10.0).f32(308, 20.0).f32(324, 30.0);
    assert_eq!(corner(&hand.bytes, 0.0, 0.0, 0.0), [-10.0, -20.0, 30.0]);
    assert_eq!(corner(&hand.bytes, 1.0, 2.0, 1.0), [-11.0, -22.0, 31.0]);
}

#[test]
fn units_are_converted_and_unknown_ones_told() {
    let mut hand = Hand::counted(false);
    hand.bytes[123] = 1;
    for i in 0..3 {
        hand.f32(280 + 20 * i, 0.002).f32(80 + 4 * i, 0.002);
    }
    let spacing = open_bytes(&hand.bytes).unwrap().grid().spacing_mm();
    // 0.002 as f32, seven digits.
    assert!(spacing.iter().all(|s| (s - 2.0).abs() < 1e-6), "{spacing:?}");
    let mut hand = Hand::counted(false);
    hand.bytes[123] = 0;
    assert!(
        open_bytes(&hand.bytes)
            .unwrap()
            .describe()
            .contains("unit of length unknown")
    );
}

macro_rules! datatypes {
    ($($name:ident: $code:literal, $type:ty, $values:expr => $want:expr, $conversion:expr;)*) => {$(
        #[test]
        fn $name() {
            for big_endian in [false, true] {
                let mut hand = Hand::new(big_endian);
                let values: [$type; 4] = $values;
                hand.dims(&[4, 4, 1, 1, 1, 0, 0, 0]).i16(70, $code).i16(72, 8 * size_of::<$type>() as i16);
                hand.voxels(&values.map(<$type>::to_le_bytes));
                let want: [i16; 4] = $want;
                assert_eq!(read_bytes(&hand.bytes).unwrap(), (want.to_vec(), $conversion));
            }
        }
    )*};
}

fn counts(clamped_low: u64, clamped_high: u64, not_finite: u64, rounded: u64) -> Conversion {
    Conversion {
        clamped_low,
        clamped_high,
        not_finite,
        rounded,
    }
}

datatypes! {
    reads_u8: 2, u8, [0, 1, 254, 255] => [0, 1, 254, 255], counts(0, 0, 0, 0);
    reads_i8: 256, i8, [-128, -1, 0, 127] => [-128, -1, 0, 127], counts(0, 0, 0, 0);
    reads_i16: 4, i16, [-32768, -1, 0, 32767] => [-32768, -1, 0, 32767], counts(0, 0, 0, 0);
    reads_u16: 512, u16, [0, 1, 32768, 65535] => [0, 1, 32767, 32767], counts(0, 2, 0, 0);
    reads_i32: 8, i32, [i32::MIN, -1207, 3382, i32::MAX] => [-32768, -1207, 3382, 32767], counts(1, 1, 0, 0);
    reads_u32: 768, u32, [0, 7, 32768, u32::MAX] => [0, 7, 32767, 32767], counts(0, 2, 0, 0);
    reads_i64: 1024, i64, [i64::MIN, -3, 4, i64::MAX] => [-32768, -3, 4, 32767], counts(1, 1, 0, 0);
    reads_u64: 1280, u64, [0, 9, 32767, u64::MAX] => [0, 9, 32767, 32767], counts(0, 1, 0, 0);
    reads_f32: 16, f32, [f32::NAN, -0.5, 1e30, 2.4] => [-1024, -1, 32767, 2], counts(0, 1, 1, 2);
    reads_f64: 64, f64, [f64::INFINITY, -1e300, 2.5, 60.0] => [-1024, -32768, 3, 60], counts(1, 0, 1, 1);
}

#[test]
fn slope_and_intercept_give_hu() {
    let mut hand = Hand::counted(false);
    hand.f32(112, 2.0).f32(116, -1000.0);
    let want: Vec<i16> = (0..12).map(|v| 2 * v - 1000).collect();
    assert_eq!(read_bytes(&hand.bytes).unwrap().0, want);
}

/// Places of a template, into which a patient is stretched, were shown as hers.
#[test]
fn places_of_a_template_are_doubted() {
    for (at, code, name) in [
        (254, 4, "sform_code is 4"),
        (254, 3, "sform_code is 3"),
        (252, 5, "qform_code is 5"),
        (254, 2, ""),
        (252, 1, ""),
    ] {
        let mut hand = Hand::counted(false);
        hand.i16(254, 0).i16(at, code);
        let said = open_bytes(&hand.bytes).unwrap().facts().warnings.join("; ");
        assert_eq!(
            (said.contains("of a template"), said.contains(name)),
            (!name.is_empty(), true),
            "{said}"
        );
    }
}

/// ITK adds the intercept and nibabel does not: 1024 HU apart, and nothing was told.
#[test]
fn an_intercept_beside_a_slope_of_0_is_no_scale_and_a_doubt() {
    let mut hand = Hand::counted(false);
    hand.f32(112, 0.0).f32(116, -1024.0);
    assert_eq!(read_bytes(&hand.bytes).unwrap().0, (0..12).collect::<Vec<i16>>());
    let said = open_bytes(&hand.bytes).unwrap().facts().warnings.join("; ");
    assert!(
        said.contains("scl_slope is 0 and scl_inter -1024") && said.contains("ITK add -1024 HU"),
        "{said}"
    );
    hand.f32(116, 0.0);
    assert_eq!(open_bytes(&hand.bytes).unwrap().facts().warnings, [""; 0]);
}

/// Numbers of a magnet and of statistics were shown as HU, whatever the header said of them.
#[test]
fn numbers_that_the_header_says_are_no_hu_are_doubted() {
    let of = |change: &dyn Fn(&mut Hand)| {
        let mut hand = Hand::counted(false);
        change(&mut hand);
        let facts = open_bytes(&hand.bytes).unwrap().facts();
        let modality = facts.extra.get("modality").and_then(|word| word.as_str());
        (facts.warnings.join("; "), modality.map(str::to_owned))
    };
    let text = |at: usize, text: &str| {
        of(&|hand: &mut Hand| {
            hand.raw(at, text.as_bytes());
        })
    };
    for (at, good) in [
        (148, "abdomen, 120 kV"),
        (148, "TE=0;Time=120.5"),
        (228, "units: HU"),
        (328, "Modality=CT"),
    ] {
        assert_eq!(text(at, good).0, "", "{good}");
    }
    assert_eq!(text(328, "Modality=CT").1.as_deref(), Some("CT"));
    let (said, modality) = text(148, "TE=2.5;Time=120.5 of Doe^John");
    assert!(
        said.contains("descrip has the word TE") && !said.contains("Doe"),
        "{said}"
    );
    assert_eq!(modality.as_deref(), Some("MR"));
    assert!(text(228, "units: cm").0.contains("aux_file has the unit cm"));
    assert!(text(328, "SUV").0.contains("intent_name has the word suv"));
    for (code, words) in [
        (3, "intent_code is 3, where a CT has 0"),
        (1002, "its numbers are labels"),
    ] {
        let (said, _) = of(&|hand: &mut Hand| {
            hand.i16(68, code);
        });
        assert!(said.contains(words), "{said}");
    }
}

#[test]
fn qform_turns_and_mirrors() {
    let mut hand = Hand::counted(false);
    hand.i16(254, 0).i16(252, 1);
    // A quarter turn about z, then spacings 2, 3, 4 mm and a mirrored third axis.
    hand.f32(264, std::f32::consts::FRAC_1_SQRT_2).f32(76, -1.0);
    hand.f32(80, 2.0).f32(84, 3.0).f32(88, 4.0);
    hand.f32(268, 5.0).f32(272, 6.0).f32(276, 7.0);
    // In RAS the first axis points anterior, the second left, the third down.
    for (voxel, ras) in [
        ([0.0, 0.0, 0.0], [5.0, 6.0, 7.0]),
        ([1.0, 0.0, 0.0], [5.0, 8.0, 7.0]),
        ([0.0, 1.0, 0.0], [2.0, 6.0, 7.0]),
        ([0.0, 0.0, 1.0], [5.0, 6.0, 3.0]),
    ] {
        let got = corner(&hand.bytes, voxel[0], voxel[1], voxel[2]);
        let want: [f64; 3] = [-ras[0], -ras[1], ras[2]];
        // The quaternion is an f32.
        assert!((0..3).all(|i| (got[i] - want[i]).abs() < 1e-6), "{got:?} {want:?}");
    }
}

#[test]
fn disagreeing_orientations_are_told() {
    let mut hand = Hand::counted(false);
    hand.i16(252, 1);
    let source = open_bytes(&hand.bytes).unwrap();
    assert!(!source.describe().contains("qform") && source.facts().warnings.is_empty());
    hand.f32(268, 1.5);
    let told = open_bytes(&hand.bytes).unwrap().describe();
    assert!(told.contains("sform 1") && told.contains("1.5 mm elsewhere"), "{told}");
    let warnings = open_bytes(&hand.bytes).unwrap().facts().warnings;
    assert!(
        warnings.len() == 1 && warnings[0].contains("1.5 mm elsewhere"),
        "{warnings:?}"
    );
    assert_eq!(corner(&hand.bytes, 0.0, 0.0, 0.0), [0.0; 3]);
}

/// A qform that is the mirror image of the sform was told as "a corner 200 mm elsewhere": other programs take it, and the other side for left.
#[test]
fn orientations_that_point_to_opposite_sides_are_refused() {
    let refused = |change: &dyn Fn(&mut Hand)| {
        let mut hand = Hand::counted(false);
        hand.i16(252, 1);
        change(&mut hand);
        open_bytes(&hand.bytes).map(drop).unwrap_err().to_string()
    };
    let mirrored = refused(&|hand| {
        hand.f32(76, -1.0);
    });
    assert!(
        mirrored.contains("point axis k of the voxels to opposite sides"),
        "{mirrored}"
    );
    // A half turn about the third axis.
    let turned = refused(&|hand| {
        hand.f32(264, 1.0);
    });
    assert!(turned.contains("point axis i of"), "{turned}");
    // A quarter turn points nothing to the other side.
    let mut hand = Hand::counted(false);
    hand.i16(252, 1).f32(264, 0.6);
    assert!(open_bytes(&hand.bytes).unwrap().facts().warnings[0].contains("elsewhere"));
}

#[test]
fn extensions_are_passed_over() {
    let mut hand = Hand::new(false);
    hand.f32(108, 10_016.0);
    hand.bytes.resize(10_016, 0xee);
    hand.voxels(&[7_i16.to_le_bytes(); 12]);
    assert_eq!(read_bytes(&hand.bytes).unwrap().0, vec![7; 12]);
    assert_eq!(read_bytes(&gzip(&hand.bytes)).unwrap().0, vec![7; 12]);
}

#[test]
fn nifti_2_in_both_byte_orders() {
    for big_endian in [false, true] {
        let mut hand = Hand {
            bytes: vec![0; 544],
            big_endian,
        };
        hand.i32(0, 540).i16(12, 4).i16(14, 16);
        hand.bytes[4..12].copy_from_slice(b"n+2\0\r\n\x1a\n");
        for (i, dim) in [3_i64, 2, 3, 2, 1, 1, 1, 1].into_iter().enumerate() {
            hand.put(16 + 8 * i, dim.to_le_bytes());
        }
        hand.put(168, 544_i64.to_le_bytes()).i32(348, 2).i32(500, 2);
        for i in 0..3 {
            hand.put(400 + 40 * i, 1.5_f64.to_le_bytes());
        }
        hand.voxels(&std::array::from_fn::<_, 12, _>(|i| (i as i16).to_le_bytes()));
        assert_eq!(read_bytes(&hand.bytes).unwrap().0, (0..12).collect::<Vec<i16>>());
        assert_eq!(corner(&hand.bytes, 1.0, 1.0, 1.0), [-1.5, -1.5, 1.5]);
    }
}
