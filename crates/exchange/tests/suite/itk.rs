//! ITK's transforms: what SimpleITK 2.5.7 wrote and where it then put a point, what is refused and with which words.

use exchange::itk::{self, ItkError};
use geometry::rotation::Rotation;
use geometry::{Marker, Point, Rigid, Tool, Vector};
use proptest::prelude::*;

/// A transform that SimpleITK wrote: without the comments and the head.
type Written = (&'static str, [f64; 3]);

/// Where each puts the point (10, 20, 30), by SimpleITK's own `TransformPoint`.
const WRITTEN: [Written; 8] = [
    (
        "Transform: Euler3DTransform_double_3_3\nParameters: 0.1 0.2 0.3 4 5 6\nFixedParameters: 1 2 3 0\n",
        [13.98629006985519, 25.94875612636285, 35.347509029205185],
    ),
    (
        "Transform: Euler3DTransform_double_3_3\nParameters: 0.1 0.2 0.3 4 5 6\nFixedParameters: 1 2 3 1\n",
        [14.370382925480436, 25.82447747875095, 35.30275596742408],
    ),
    (
        "Transform: VersorRigid3DTransform_double_3_3\nParameters: 0.14844237555271375 0 0.19792316740361837 4 5 6\nFixedParameters: 1 2 3\n",
        [7.977677798488791, 18.48165626658888, 40.51674165113341],
    ),
    (
        "Transform: AffineTransform_double_3_3\nParameters: 0.9304320636570301 -0.29404383655185584 0.2187107612916787 0.3085774668591277 0.9505637859220634 -0.034762563776535 -0.19767681165408388 0.09983341664682815 0.975170327201816 1 2 3\nFixedParameters: 9 8 7\n",
        [12.43225353474337, 20.915803931063586, 33.42924171374962],
    ),
    (
        "Transform: CompositeTransform_double_3_3\n#Transform 1\nTransform: TranslationTransform_double_3_3\nParameters: 1 2 3\nFixedParameters: \n#Transform 2\nTransform: Euler3DTransform_double_3_3\nParameters: 0.1 0.2 0.3 4 5 6\nFixedParameters: 1 2 3 0\n#Transform 3\nTransform: AffineTransform_double_3_3\nParameters: 0.9304320636570301 -0.29404383655185584 0.2187107612916787 0.3085774668591277 0.9505637859220634 -0.034762563776535 -0.19767681165408388 0.09983341664682815 0.975170327201816 1 2 3\nFixedParameters: 9 8 7\n",
        [17.730062309971725, 29.45061557896785, 41.30223150479075],
    ),
    (
        "Transform: TranslationTransform_double_3_3\nParameters: 1 2 3\nFixedParameters: \n",
        [11.0, 22.0, 33.0],
    ),
    (
        "Transform: IdentityTransform_double_3_3\nParameters: \nFixedParameters: \n",
        [10.0, 20.0, 30.0],
    ),
    (
        "Transform: MatrixOffsetTransformBase_float_3_3\nParameters: 0 -1 0 1 0 0 0 0 1 1 2 3\nFixedParameters: 0 0 0\n",
        [-19.0, 12.0, 33.0],
    ),
];

fn text(body: &str) -> String {
    format!("#Insight Transform File V1.0\n#Transform 0\n{body}")
}

fn read(bytes: &[u8]) -> Result<Rigid<Marker, Tool>, ItkError> {
    itk::read(bytes).map(|read| read.to_from_from)
}

fn off(rigid: Rigid<Marker, Tool>, place: [f64; 3]) -> f64 {
    let [x, y, z] = place;
    (rigid * Point::new(10.0, 20.0, 30.0)).distance(Point::new(x, y, z))
}

#[test]
fn points_go_where_simpleitk_puts_them() {
    for (body, place) in WRITTEN {
        let rigid = read(text(body).as_bytes()).unwrap_or_else(|error| panic!("{body}: {error}"));
        assert!(off(rigid, place) < 1e-9, "{body}: {}", off(rigid, place));
    }
    // The file that `WRITTEN` begins with, as HDF5.
    let rigid = read(include_bytes!("../data/euler.h5")).unwrap();
    assert!(off(rigid, WRITTEN[0].1) < 1e-9, "{}", off(rigid, WRITTEN[0].1));
}

#[test]
fn what_is_not_rigid_is_refused_with_how_far_off_it_is() {
    let affine = |numbers: &str| {
        text(&format!(
            "Transform: AffineTransform_double_3_3\nParameters: {numbers}\nFixedParameters: 0 0 0\n"
        ))
    };
    let of = |kind: &str, numbers: &str, fixed: &str| {
        text(&format!(
            "Transform: {kind}_double_3_3\nParameters: {numbers}\nFixedParameters: {fixed}\n"
        ))
    };
    for (file, words) in [
        (
            affine("1 0 0 0 1 0 0 0 1.001 0 0 0"),
            "1.00e-3 from the nearest rotation",
        ),
        (affine("1 0.01 0 0 1 0 0 0 1 0 0 0"), "is not rigid"),
        (affine("1000 0 0 0 1000 0 0 0 1000 0 0 0"), "columns are [1000.00000"),
        (affine("1 0 0 0 1 0 0 0 -1 0 0 0"), "a reflection, determinant -1"),
        (
            affine("0 0 0 0 0 0 0 0 0 0 0 0"),
            "transform 1 (AffineTransform_double_3_3)",
        ),
        (affine("1 0 0 0 1 0 0 0 nan 0 0 0"), "NaN among its numbers"),
        (affine("1 0 0 0 1 0 0 0 1 0 0 1e300"), "finite numbers of at most 1e9"),
        (affine("1 0 0 0 1 0 0 0 1 0 0"), "11 Parameters; expected 12"),
        (affine(&"1 ".repeat(1000)), "at most 16 numbers"),
        (
            of("Similarity3DTransform", "0 0 0 0 0 0 1.1", "0 0 0"),
            "columns are [1.10000, 1.10000, 1.10000]",
        ),
        (
            of("VersorRigid3DTransform", "0.8 0 0.7 0 0 0", "0 0 0"),
            "a versor of length 1.06",
        ),
        (
            of("Euler3DTransform", "0 -90 0 0 0 0", "0 0 0"),
            "angles of [0.0, -90.0, 0.0]; radians of at most a whole turn",
        ),
        (
            of("Euler3DTransform", "0 0 0 0 0 0", "0 0"),
            "2 FixedParameters; expected the three of a centre",
        ),
        (
            of("BSplineTransform", &"0 ".repeat(100_000), "5 5 5"),
            "is a BSplineTransform_double_3_3",
        ),
        (
            of("DisplacementFieldTransform", "", ""),
            "is a DisplacementFieldTransform_double_3_3",
        ),
        (
            text("Transform: Euler2DTransform_double_2_2\nParameters: 0 0 0\nFixedParameters: 0 0\n"),
            "three dimensions",
        ),
        (
            text("Transform: AffineTransform_double_2_3\n"),
            "is a AffineTransform_double_2_3",
        ),
        (text(&WRITTEN[5].0.repeat(2)), "2 transforms and no CompositeTransform"),
        (
            text(&format!("{}{}", WRITTEN[5].0, WRITTEN[4].0)),
            "a composite as the first transform alone",
        ),
        (text("Parameters: 1 2 3\n"), "Transform: before its numbers"),
        (
            text("Transform: IdentityTransform_double_3_3\nScale: 2\n"),
            "line 4: \"Scale: 2\"",
        ),
        (
            text(WRITTEN[0].0).replace("FixedParameters:", "Parameters:"),
            "the numbers of a transform once",
        ),
        (text(""), "there is no transform"),
        (
            format!(
                "#Insight Transform File V1.0\n{}",
                "Transform: IdentityTransform_double_3_3\n".repeat(300)
            ),
            "more than 256",
        ),
        ("# something else\n".to_owned(), "it begins with \"# something else\""),
        (String::new(), "it begins with \"\""),
    ] {
        let said = read(file.as_bytes()).unwrap_err().to_string();
        assert!(said.contains(words), "{words}: {said}");
        assert!(said.len() < 500, "{said}");
    }
    assert!(
        read(b"#Insight Transform File V1.0\n\xff\xfe")
            .unwrap_err()
            .to_string()
            .contains("line 2")
    );
}

/// Numbers that are each allowed made a translation that is not: what was written of it was not read again.
#[test]
fn centres_and_translations_do_not_add_up_beyond_what_is_read() {
    let body =
        "Transform: AffineTransform_double_3_3\nParameters: 0 -1 0 1 0 0 0 0 1 1e9 0 0\nFixedParameters: 1e9 1e9 0\n";
    let said = read(text(body).as_bytes()).unwrap_err().to_string();
    assert!(said.contains("3000000000 among its numbers"), "{said}");
}

/// A scale that was let pass in each part moved the tip of a tool by 5.2 mm in 256 of them, and nothing was said.
#[test]
fn a_composite_is_judged_whole() {
    let part = "Transform: Similarity3DTransform_double_3_3\nParameters: 0 0 0 0 0 0 1.0001\nFixedParameters: 0 0 0\n";
    let last = "Transform: TranslationTransform_double_3_3\nParameters: 0 0 200\nFixedParameters: \n";
    let composite = |count: usize| {
        text(&format!(
            "Transform: CompositeTransform_double_3_3\n{}{last}",
            part.repeat(count)
        ))
    };
    let said = read(composite(255).as_bytes()).unwrap_err().to_string();
    assert!(
        said.contains("together are not rigid") && said.contains("1.0258"),
        "{said}"
    );
    assert!(read(composite(2).as_bytes()).is_err());
    let one = itk::read::<Marker, Tool>(composite(1).as_bytes()).unwrap();
    // 200 mm, a ten-thousandth longer, is what SimpleITK makes of it.
    let moved = one.moved(Point::new(0.0, 0.0, 0.0));
    assert!((moved - 0.02).abs() < 1e-9, "{moved}");
}

/// A matrix that is a little off was put right about a centre far away, where the tip is not.
#[test]
fn what_putting_right_moves_is_told_by_the_point() {
    let body = "Transform: AffineTransform_double_3_3\nParameters: 1.000115 0 0 0 1.000115 0 0 0 1.000115 12.5 -40 160\nFixedParameters: 9000 0 0\n";
    let read = itk::read::<Marker, Tool>(text(body).as_bytes()).unwrap();
    // By hand: the origin lies 9000 mm from the centre.
    let moved = read.moved(Point::new(0.0, 0.0, 0.0));
    assert!((moved - 9000.0 * 1.15e-4).abs() < 1e-9, "{moved}");
    assert!(read.moved(Point::new(9000.0, 0.0, 0.0)) < 1e-9);
}

/// It was the identity, which nobody had said; and numbers of a composite were passed over.
#[test]
fn a_composite_of_nothing_or_with_numbers_is_refused() {
    let empty = text("Transform: CompositeTransform_double_3_3\n");
    assert_eq!(read(empty.as_bytes()), Err(ItkError::Empty));
    let numbers = WRITTEN[4].0.replacen('\n', "\nParameters: 1 2 3\n", 1);
    let said = read(text(&numbers).as_bytes()).unwrap_err().to_string();
    assert!(said.contains("3 numbers of its own; expected none"), "{said}");
}

#[test]
fn as_many_transforms_are_read_as_are_stated() {
    let one = WRITTEN[6].0;
    let composite = |count: usize| {
        text(&format!(
            "Transform: CompositeTransform_double_3_3\n{}",
            one.repeat(count)
        ))
    };
    assert!(read(composite(itk::MAX_PARTS).as_bytes()).is_ok());
    assert_eq!(read(composite(itk::MAX_PARTS + 1).as_bytes()), Err(ItkError::TooMany));
}

#[test]
fn a_mark_before_the_text_is_none_of_it_and_what_is_quoted_moves_no_cursor() {
    let marked = format!("\u{feff}{}", text(WRITTEN[0].0));
    assert!(off(read(marked.as_bytes()).unwrap(), WRITTEN[0].1) < 1e-9);
    let said = read(text("Transform: \u{1b}[31mHello\u{202e}\u{7}_double_3_3\n").as_bytes())
        .unwrap_err()
        .to_string();
    assert!(said.contains("is a ?[31mHello??_double_3_3"), "{said:?}");
}

/// Written by h5py 3 as ITK up to 5.0 did, whose names lacked a letter.
#[test]
fn hdf5_with_the_old_names_is_read() {
    let rigid = read(include_bytes!("../data/old_names.h5")).unwrap();
    assert!(off(rigid, [20.0, 40.0, 190.0]) < 1e-12);
}

/// By h5py 3 too: half precision, and a type of 2^33 and 2^40 words in 6 KB, for which memory was asked until the process was aborted.
#[test]
fn hdf5_that_promises_more_than_itk_writes_is_refused_before_it_is_read() {
    for (bytes, words) in [
        (&include_bytes!("../data/half.h5")[..], "TransformParameters: of "),
        (
            include_bytes!("../data/many_words.h5"),
            "TransformType: of shape [1099511627776]",
        ),
        (
            include_bytes!("../data/many_words_chunked.h5"),
            "TransformType: of shape [8589934592]",
        ),
    ] {
        let said = read(bytes).unwrap_err().to_string();
        assert!(said.contains(words), "{said}");
    }
}

/// Each byte of a file of HDF5 another one, and the file cut off at every place.
#[test]
fn damaged_hdf5_is_refused_or_read_and_never_more() {
    let good = include_bytes!("../data/euler.h5");
    let mut refused = 0;
    for place in 0..good.len() {
        for value in [0, 0xff, good[place] ^ 0x10] {
            let mut bytes = good.to_vec();
            bytes[place] = value;
            refused += usize::from(read(&bytes).is_err());
        }
        refused += usize::from(read(&good[..place]).is_err());
    }
    assert!(refused > 1000, "{refused}");
}

/// Small matrices of four decimals, as people copy them: put right about the centre, and told.
#[test]
fn four_decimals_are_put_right_and_told() {
    let body = "Transform: AffineTransform_double_3_3\nParameters: 0.9924 0.0793 0.0941 -0.0868 0.9931 0.0793 -0.0872 -0.0868 0.9924 0 0 0\n\
                FixedParameters: 100 200 300\n";
    let read = itk::read::<Marker, Tool>(text(body).as_bytes()).unwrap();
    assert!(
        read.most_off > 1e-6 && read.most_off <= itk::MOST_OFF,
        "{}",
        read.most_off
    );
    let centre = Point::new(100.0, 200.0, 300.0);
    assert!((read.to_from_from * centre).distance(Point::new(100.0, 200.0, 300.0)) < 1e-9);
}

proptest! {
    #[test]
    fn what_is_written_is_read_to_1e_9_mm_and_slicers_node_is_its_inverse_turned(
        q in prop::array::uniform4(-1.0..1.0f64), t in prop::array::uniform3(-1e3..1e3f64),
        p in prop::array::uniform3(-500.0..500.0f64),
    ) {
        let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
        prop_assume!(norm > 0.1);
        let rotation = Rotation::from_quaternion(q.map(|x| x / norm)).unwrap();
        let given = Rigid::<Marker, Tool>::from_parts(rotation, Vector::new(t[0], t[1], t[2]));
        let p = Point::<Tool>::new(p[0], p[1], p[2]);
        let back = read(itk::write(&given).as_bytes()).unwrap();
        prop_assert!((back * p).distance(given * p) < 1e-9);

        // By hand, as Slicer does on reading: the inverse, between the two turns by half a circle about z.
        let file = itk::slicer_file(&given);
        let half = |[x, y, z]: [f64; 3]| [-x, -y, z];
        let [x, y, z] = half((given * p).mm());
        let [x, y, z] = half((file * Point::<Marker>::new(x, y, z)).mm());
        prop_assert!(Point::<Tool>::new(x, y, z).distance(p) < 1e-9);
        prop_assert!((itk::slicer_node(&file) * p).distance(given * p) < 1e-9);
    }
}
