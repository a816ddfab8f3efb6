//! Cards that go, that are wrong, that are late, that are not there, and who draws then.

use bus::message::GPU_GIVEN_UP;
use scene::{BackEnd, Render};

use super::super::super::{Chosen, Reference};
use super::*;

/// A card of any kind, prepared for `samplings` and proved; `None`, with a word, where there is no card.
fn proved(volume: &OwnedVolume, samplings: &[Sampling]) -> Option<Chosen> {
    let mut chosen = Chosen::new(Render {
        back_end: BackEnd::Gpu,
        gpu_weights: GpuWeights::Exact,
    });
    chosen.prepare(&volume.view(), samplings, &mut || {}).unwrap();
    assert!(chosen.gpu().is_none() && chosen.note().ends_with("(a GPU is being tried)"));
    chosen.settle(&volume.view());
    if chosen.gpu().is_none() {
        println!("skipped: {}", chosen.name());
        assert!(!chosen.name().contains(GPU_GIVEN_UP), "{}", chosen.name());
        return None;
    }
    Some(chosen)
}

/// The same, up to the point where `volume` is on the card and nothing was compared.
fn loaded(volume: &OwnedVolume, samplings: &[Sampling]) -> Option<Chosen> {
    let mut chosen = Chosen::new(Render {
        back_end: BackEnd::Gpu,
        gpu_weights: GpuWeights::Exact,
    });
    chosen.prepare(&volume.view(), samplings, &mut || {}).unwrap();
    while chosen.advance(&volume.view()) {
        if chosen
            .on_trial()
            .is_some_and(|gpu| gpu.prepared.as_ref().unwrap().is_whole())
        {
            return Some(chosen);
        }
    }
    println!("skipped: {}", chosen.name());
    None
}

fn prepared_cpu(volume: &OwnedVolume, samplings: &[Sampling]) -> Cpu {
    let mut cpu = Cpu::default();
    cpu.prepare(&volume.view(), samplings, &mut || {}).unwrap();
    cpu
}

/// Whether the CPU draws, now and from now on, and says so.
fn assert_fallen(chosen: &mut Chosen, cpu: &mut Cpu, volume: &OwnedVolume, how: &str) {
    let plane = plane(volume, [0.0; 3], [0.3, 0.2, 1.0], 0.5, [64, 64]).unwrap();
    for sampling in &samplings() {
        let expected = drawn(cpu, volume, &plane, sampling);
        assert_eq!(drawn(chosen, volume, &plane, sampling), expected, "{sampling:?}");
        let words = format!("{} ({GPU_GIVEN_UP} {how}: ", cpu.name());
        assert!(chosen.name().starts_with(&words), "{}", chosen.name());
        assert_eq!(chosen.gpu_bytes(), None);
        assert_eq!(chosen.caution(), format!("GPU {}, CPU DRAWS", how.to_uppercase()));
    }
}

#[test]
fn a_lost_card_leaves_the_image_to_the_cpu() {
    let (volume, samplings) = (noise([40, 37, 19], [4, 4, 4]), samplings());
    let Some(mut chosen) = proved(&volume, &samplings) else {
        return;
    };
    let plane = plane(&volume, [0.0; 3], [0.3, 0.2, 1.0], 0.5, [64, 64]).unwrap();
    drawn(&mut chosen, &volume, &plane, &samplings[0]);
    assert!(chosen.gpu_bytes().is_some() && chosen.name().starts_with("gpu "));
    assert_eq!(chosen.caution(), "");
    chosen.gpu().unwrap().lose();
    assert_fallen(&mut chosen, &mut prepared_cpu(&volume, &samplings), &volume, "lost");
}

/// The voxels on the card are overwritten with zeros, as by bad memory: the very next image is the CPU's.
#[test]
fn a_card_with_other_voxels_leaves_the_image_to_the_cpu() {
    let (volume, samplings) = (noise([40, 37, 19], [4, 4, 4]), samplings());
    let Some(mut chosen) = proved(&volume, &samplings) else {
        return;
    };
    chosen.gpu().unwrap().spoil();
    assert_fallen(&mut chosen, &mut prepared_cpu(&volume, &samplings), &volume, "wrong");
}

#[test]
fn a_card_that_takes_longer_than_the_cpu_would_leaves_the_image_to_the_cpu() {
    let (volume, samplings) = (noise([40, 37, 19], [4, 4, 4]), samplings());
    let Some(mut chosen) = proved(&volume, &samplings) else {
        return;
    };
    // A program on the CPU is not watched for its speed unless it is taken for hardware.
    chosen.take_for_hardware();
    let plane = plane(&volume, [0.0; 3], [0.3, 0.2, 1.0], 0.5, [64, 64]).unwrap();
    chosen.pace().of_cpu([64, 64], &samplings[0], 1);
    let images = (1..=64).find(|_| {
        drawn(&mut chosen, &volume, &plane, &samplings[0]);
        chosen.gpu().is_none()
    });
    assert!(images.is_some());
    // On the whole it is slower, which is nothing that an operator need be told; on a busy machine one image may be late by itself.
    if chosen.name().contains(GPU_GIVEN_UP) {
        return assert_fallen(&mut chosen, &mut prepared_cpu(&volume, &samplings), &volume, "late");
    }
    assert!(chosen.name().contains("(the GPU is slower: "), "{}", chosen.name());
    assert_eq!(chosen.caution(), "");
    let here = drawn(&mut chosen, &volume, &plane, &samplings[0]);
    let expected = drawn(&mut prepared_cpu(&volume, &samplings), &volume, &plane, &samplings[0]);
    assert_eq!(here, expected);
}

/// It is closed beside the drawing, as to close one that is at work waits for it.
#[test]
fn a_card_that_is_still_at_work_when_its_time_is_over_leaves_the_image_to_the_cpu() {
    let volume = noise([40, 37, 19], [4, 4, 4]);
    let sampling = Sampling {
        slab: Some(Slab {
            mode: SlabMode::Mean,
            thickness_mm: 20.0,
        }),
        ..Sampling::from(Filter::Sinc5)
    };
    let Some(mut chosen) = proved(&volume, &[sampling]) else {
        return;
    };
    chosen.take_for_hardware();
    let plane = plane(&volume, [0.0; 3], [0.3, 0.2, 1.0], 0.1, [300, 300]).unwrap();
    chosen.pace().of_cpu([300, 300], &sampling, 1);
    chosen.pace().be_strict();
    let drawn_by_cpu = drawn(&mut prepared_cpu(&volume, &[sampling]), &volume, &plane, &sampling);
    assert_eq!(drawn(&mut chosen, &volume, &plane, &sampling), drawn_by_cpu);
    let words = format!("({GPU_GIVEN_UP} late: ");
    assert!(
        chosen.gpu().is_none() && chosen.name().contains(&words),
        "{}",
        chosen.name()
    );
}

#[test]
fn a_card_that_draws_a_test_image_wrong_never_draws_another() {
    let (volume, samplings) = (noise([40, 37, 19], [4, 4, 4]), samplings());
    let Some(mut chosen) = loaded(&volume, &samplings) else {
        return;
    };
    chosen.on_trial().unwrap().spoil();
    chosen.settle(&volume.view());
    assert!(chosen.gpu().is_none());
    let words = format!("({GPU_GIVEN_UP} unusable: 0.00 HU at pixel ");
    assert!(chosen.name().contains(&words), "{}", chosen.name());
    // No image was ever its own.
    assert_eq!(chosen.caution(), "");
}

#[test]
fn a_card_lost_on_trial_leaves_the_images_to_the_cpu() {
    let (volume, samplings) = (noise([40, 37, 19], [4, 4, 4]), samplings());
    let Some(mut chosen) = loaded(&volume, &samplings) else {
        return;
    };
    chosen.on_trial().unwrap().lose();
    chosen.settle(&volume.view());
    assert!(
        chosen.gpu().is_none() && chosen.name().contains(&format!("({GPU_GIVEN_UP} unusable: ")),
        "{}",
        chosen.name()
    );
}

/// A loader that was started again publishes the same examination in other memory.
#[test]
fn another_volume_is_proved_anew() {
    let (volume, samplings) = (noise([40, 37, 19], [4, 4, 4]), samplings());
    let Some(mut chosen) = proved(&volume, &samplings) else {
        return;
    };
    let again = noise([40, 37, 19], [4, 4, 4]);
    chosen.prepare(&again.view(), &samplings, &mut || {}).unwrap();
    assert!(chosen.gpu().is_none() && chosen.name() == Cpu::default().name());
    chosen.settle(&again.view());
    assert!(chosen.gpu().is_some(), "{}", chosen.name());
    let plane = plane(&again, [0.0; 3], [0.3, 0.2, 1.0], 0.5, [64, 64]).unwrap();
    drawn(&mut chosen, &again, &plane, &samplings[0]);
    assert!(chosen.gpu().is_some(), "{}", chosen.name());
}

#[test]
fn without_a_card_the_cpu_draws_and_says_why() {
    let mut chosen = Chosen::among(Render::default(), Some(Accepted::Nothing));
    let (volume, sampling) = (noise([8, 8, 8], [4, 4, 4]), Sampling::from(Filter::BSpline));
    let plane = plane(&volume, [0.0; 3], [0.0, 0.0, 1.0], 0.5, [16, 16]).unwrap();
    chosen.prepare(&volume.view(), &[sampling], &mut || {}).unwrap();
    chosen.settle(&volume.view());
    assert_eq!(chosen.name(), format!("{} (no GPU)", Cpu::default().name()));
    assert_eq!(chosen.note(), chosen.name());
    let mut exact = Reference::default();
    exact.prepare(&volume.view(), &[sampling], &mut || {}).unwrap();
    let (a, b) = (
        drawn(&mut chosen, &volume, &plane, &sampling),
        drawn(&mut exact, &volume, &plane, &sampling),
    );
    compare(&chosen, &sampling, &a, &b).unwrap();
}

#[test]
fn auto_never_takes_a_program_on_the_cpu() {
    let (volume, samplings) = (noise([8, 8, 8], [4, 4, 4]), samplings());
    let settled = |back_end| {
        let mut chosen = Chosen::new(Render {
            back_end,
            ..Render::default()
        });
        chosen.prepare(&volume.view(), &samplings, &mut || {}).unwrap();
        chosen.settle(&volume.view());
        chosen
    };
    let chosen = settled(BackEnd::Auto);
    match chosen.gpu() {
        Some(gpu) => assert_ne!(gpu.card.info.device_type, wgpu::DeviceType::Cpu),
        None => assert!(chosen.name().ends_with(')'), "{}", chosen.name()),
    }
    assert_eq!(settled(BackEnd::Cpu).name(), Cpu::default().name());
}

/// No image that is right is called wrong: the pixels compared are those of planes at random and at ties.
#[test]
fn a_card_that_is_right_is_never_taken_for_wrong() {
    let (volume, samplings) = (noise([40, 37, 19], [4, 4, 4]), samplings());
    let Some(mut chosen) = proved(&volume, &samplings) else {
        return;
    };
    let mut draw = |plane: &SlicePlane, sampling: &Sampling| {
        drawn(&mut chosen, &volume, plane, sampling);
        assert!(chosen.gpu().is_some(), "{sampling:?} {plane:?}: {}", chosen.name());
    };
    let mut random = 1_u64;
    let mut number = || {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (random >> 11) as f64 / (1_u64 << 53) as f64
    };
    for _ in 0..150 {
        let off = [0, 1, 2].map(|_| 40.0 * number() - 20.0);
        let normal = [0, 1, 2].map(|_| 2.0 * number() - 1.0);
        let Some(plane) = plane(&volume, off, normal, 0.05 + 3.0 * number(), [61, 47]) else {
            continue;
        };
        draw(&plane, &samplings[(number() * samplings.len() as f64) as usize]);
    }
    // Along an axis, on voxels, between them and on the border.
    for sampling in &samplings {
        for off in [0.0, 0.25, 0.5, -9.5, -10.0] {
            let Some(plane) = plane(&volume, [off; 3], [0.0, 0.0, 1.0], 0.4, [61, 47]) else {
                continue;
            };
            draw(&plane, sampling);
        }
    }
}
