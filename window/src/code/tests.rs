use proptest::prelude::*;

use super::*;

const KEY: u32 = 0x1234_5678;

fn shown() -> impl Strategy<Value = Shown> {
    prop::sample::select(Shown::ALL.map(|(shown, _)| shown).to_vec())
}

fn codes() -> impl Strategy<Value = Code> {
    (any::<u64>(), any::<i64>(), shown()).prop_map(|(seq, t, shown)| Code::new(seq, t, shown))
}

/// A stream of numbers that looks like no pattern of a code (splitmix64).
fn random(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}

fn random_code(state: &mut u64) -> Code {
    let shown = Shown::ALL[random(state) as usize % 4].0;
    Code::new(random(state), random(state) as i64, shown)
}

/// The upper `cut` pixel rows of one image, the others of another.
fn torn(a: &[u8], b: &[u8], cut: u32, square: u32) -> Vec<u8> {
    let at = (cut * COLUMNS * square * 4) as usize;
    [&a[..at], &b[at..]].concat()
}

fn flip(image: &mut [u8], square: u32, [column, row]: [u32; 2]) {
    for y in row * square..(row + 1) * square {
        for x in column * square..(column + 1) * square {
            let at = ((y * COLUMNS * square + x) * 4) as usize;
            image[at..at + 3].iter_mut().for_each(|channel| *channel = !*channel);
        }
    }
}

proptest! {
    #[test]
    fn every_code_comes_back(code in codes(), key in any::<u32>(), square in 3_u32..=9) {
        prop_assert_eq!(Code::of_word(code.word()), Some(code));
        prop_assert_eq!(Grid::read(&code.grid(key).rgba(square), square, key), Ok(code));
    }

    #[test]
    fn another_runs_cell_is_refused(code in codes(), key in any::<u32>(), other in any::<u32>()) {
        prop_assume!(key != other);
        prop_assert_eq!(Grid::read(&code.grid(key).rgba(4), 4, other), Err(Unread::CheckSum));
    }

    #[test]
    fn one_or_two_wrong_squares_are_refused(code in codes(), a in 0..COLUMNS * ROWS, b in 0..COLUMNS * ROWS) {
        let mut image = code.grid(KEY).rgba(4);
        for at in [a, b].into_iter().take(if a == b { 1 } else { 2 }) {
            flip(&mut image, 4, [at % COLUMNS, at / COLUMNS]);
        }
        prop_assert!(Grid::read(&image, 4, KEY).is_err());
    }

    #[test]
    fn no_bytes_make_it_panic(pixels in prop::collection::vec(any::<u8>(), 0..6000), square in any::<u32>()) {
        prop_assert!(Grid::read(&pixels, square % 70, KEY).is_err());
    }

    #[test]
    fn ages_are_right_to_a_millisecond(t in any::<i32>(), age in 0_i64..3_600_000_000_000) {
        let t = i64::from(t) * 1_000_000_007;
        let found = Code::new(0, t, Shown::Live).age_ms(t + age);
        prop_assert!(found * 1_000_000 >= age && found * 1_000_000 < age + 2_000_000, "{} of {}", found, age);
    }
}

#[test]
fn a_number_that_begins_anew_goes_on() {
    let code = |seq| Code::new(seq, 0, Shown::Live);
    assert!(code(1 << SEQ_BITS).is_behind(code((1 << SEQ_BITS) - 1)));
    assert!(code(8).is_behind(code(7)));
    assert!(!code(7).is_behind(code(7)) && !code(7).is_behind(code(8)));
    assert_eq!(code((1 << SEQ_BITS) + 3).seq(), 3);
}

/// The sum is linear but for a constant: what four or fewer flips do to one code they do to each. All of them are tried.
#[test]
fn up_to_four_wrong_squares_are_refused_whichever_they_are() {
    let flips: Vec<u128> = (0..96).map(|bit| 1 << bit).collect();
    let zero = Grid::of(0, KEY).0;
    // What a flip leaves between the sum that is there and the one that ought to be.
    let left = |flip: u128| {
        let word = (flip >> 32) as u64;
        (Grid::of(word, KEY).0 ^ zero ^ flip) as u32
    };
    let single: Vec<u32> = flips.iter().map(|flip| left(*flip)).collect();
    let mut pairs: Vec<u32> = Vec::new();
    for (i, a) in single.iter().enumerate() {
        assert_ne!(*a, 0);
        pairs.extend(single[..i].iter().map(|b| a ^ b));
    }
    assert!(!pairs.contains(&0), "two");
    pairs.sort_unstable();
    assert!(single.iter().all(|a| pairs.binary_search(a).is_err()), "three");
    // Two pairs that leave the same would be four flips that leave nothing; pairs that share a flip were two.
    assert!(pairs.windows(2).all(|two| two[0] != two[1]), "four");
}

/// All cuts at rows of pixels, so within squares too, of pairs with nothing in common.
#[test]
fn torn_cells_are_refused_or_are_one_of_the_two() {
    const SQUARE: u32 = 3;
    let mut state = 1;
    for _ in 0..300 {
        let (a, b) = (random_code(&mut state), random_code(&mut state));
        let (upper, lower) = (a.grid(KEY).rgba(SQUARE), b.grid(KEY).rgba(SQUARE));
        for cut in 0..=ROWS * SQUARE {
            let read = Grid::read(&torn(&upper, &lower, cut, SQUARE), SQUARE, KEY);
            assert!(
                read.is_err() || read == Ok(a) || read == Ok(b),
                "{a:?} {b:?} cut at {cut}: {read:?}"
            );
        }
    }
}

/// How many cuts of a pair at rows of squares pass for a third code.
fn undetected(a: Code, b: Code) -> u32 {
    let (a, b) = (a.grid(KEY), b.grid(KEY));
    let lower = |cut: u32| (1_u128 << (96 - 12 * cut)) - 1;
    let passes = |cut: &u32| {
        let mix = a.0 & !lower(*cut) | b.0 & lower(*cut);
        let is_third = mix != a.0 && mix != b.0;
        is_third && Grid::of((mix >> 32) as u64, KEY).0 == mix
    };
    (1..8).filter(passes).count() as u32
}

#[test]
fn of_a_hundred_thousand_pairs_no_torn_one_passes_for_a_third() {
    let mut state = 2;
    let random_pairs: u32 = (0..100_000)
        .map(|_| undetected(random_code(&mut state), random_code(&mut state)))
        .sum();
    // Pictures that follow one another, the ones that a torn read mixes.
    let mut neighbours = 0;
    for seq in 0..1000 {
        for ms in 0..100 {
            let of = |seq, ms: i64| Code::new(seq, ms * 1_000_000, Shown::Live);
            let t = 977 * seq as i64;
            neighbours += undetected(of(seq, t), of(seq + 1, t + ms));
        }
    }
    println!("undetected: {random_pairs} of 700000 random cuts, {neighbours} of 700000 of neighbours");
    assert_eq!((random_pairs, neighbours), (0, 0));
}

#[test]
fn what_is_no_cell_is_refused_by_name() {
    let code = Code::new(7, 1, Shown::Live);
    let good = code.grid(KEY).rgba(4);
    assert_eq!(
        Grid::read(&code.grid(KEY).rgba(*SQUARE_PX.end()), *SQUARE_PX.end(), KEY),
        Ok(code)
    );
    for grey in [0, 255] {
        let plain = vec![grey; good.len()];
        assert!(Grid::read(&plain, 4, KEY).is_err(), "all of {grey}");
    }
    let grey = vec![127; good.len()];
    assert_eq!(Grid::read(&grey, 4, KEY), Err(Unread::Grey));
    assert_eq!(Grid::read(&good[4..], 4, KEY), Err(Unread::Size));
    // One square to the right.
    let shifted: Vec<u8> = good.iter().skip(16).chain(&good[..16]).copied().collect();
    assert!(Grid::read(&shifted, 4, KEY).is_err());
    // Half transparent black over it, as menus and notices are.
    let dimmed: Vec<u8> = good.iter().map(|channel| channel / 2).collect();
    assert_eq!(Grid::read(&dimmed, 4, KEY), Err(Unread::Grey));
    let version = Grid::of(code.word() ^ 3 << 60, KEY).rgba(4);
    assert_eq!(Grid::read(&version, 4, KEY), Err(Unread::Version));
}

/// A painter that smooths edges over a pixel does no harm.
#[test]
fn edges_may_be_smooth() {
    let code = Code::new(9, 5, Shown::Replay);
    let mut image = code.grid(KEY).rgba(4);
    for y in 0..ROWS * 4 {
        for x in (0..COLUMNS * 4).filter(|x| x % 4 == 0) {
            let at = ((y * COLUMNS * 4 + x) * 4) as usize;
            image[at..at + 3].fill(128);
        }
    }
    assert_eq!(Grid::read(&image, 4, KEY), Ok(code));
}

#[test]
fn places_come_back_and_nonsense_is_refused() {
    let place = Place {
        at: [1800, 4],
        square: 5,
        key: KEY,
        pid: 77,
    };
    let good = place.to_cardinals();
    assert_eq!(Place::of_cardinals(&good), Ok(place));
    assert_eq!(place.size(), [70, 50]);
    assert_eq!(Place::of_cardinals(&good[1..]), Err(PlaceError::Length(7)));
    for (at, bad) in [(0, u32::MAX), (1, 32_768), (2, 0), (2, 65), (3, 13), (4, 0), (5, 2)] {
        let mut cardinals = good;
        cardinals[at] = bad;
        assert!(Place::of_cardinals(&cardinals).is_err(), "{at}: {bad}");
    }
}
