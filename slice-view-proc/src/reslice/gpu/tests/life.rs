//! Cards that go, cards that are not there, and who draws then.

use bus::scene::{BackEnd, Render};

use super::super::super::{Chosen, Reference};
use super::*;

#[test]
fn a_lost_card_leaves_the_image_to_the_cpu() {
    let mut chosen = Chosen::new(Render {
        back_end: BackEnd::Gpu,
        gpu_weights: GpuWeights::Exact,
    });
    let Some(before) = chosen.gpu().map(|gpu| gpu.name().to_owned()) else {
        println!("skipped: {}", chosen.name());
        return;
    };
    assert_eq!(chosen.name(), before);
    let (volume, mut cpu, samplings) = (noise([40, 37, 19], [4, 4, 4]), Cpu::default(), samplings());
    chosen.prepare(&volume.view(), &samplings, &mut || {}).unwrap();
    cpu.prepare(&volume.view(), &samplings, &mut || {}).unwrap();
    let plane = plane(&volume, [0.0; 3], [0.3, 0.2, 1.0], 0.5, [64, 64]).unwrap();
    drawn(&mut chosen, &volume, &plane, &samplings[0]);
    assert!(chosen.gpu_bytes().is_some());
    assert_eq!(chosen.caution(), "");
    chosen.gpu().unwrap().lose();
    for sampling in &samplings {
        let expected = drawn(&mut cpu, &volume, &plane, sampling);
        assert_eq!(drawn(&mut chosen, &volume, &plane, sampling), expected, "{sampling:?}");
        assert!(
            chosen.name().starts_with(&format!("{} (GPU lost: ", cpu.name())),
            "{}",
            chosen.name()
        );
        assert_eq!(chosen.gpu_bytes(), None);
        assert_eq!(chosen.caution(), "GPU LOST, CPU DRAWS");
    }
}

#[test]
fn a_card_lost_before_the_volume_comes_leaves_it_to_the_cpu() {
    let mut chosen = Chosen::new(Render {
        back_end: BackEnd::Gpu,
        gpu_weights: GpuWeights::Exact,
    });
    let Some(gpu) = chosen.gpu() else { return };
    gpu.lose();
    let volume = noise([40, 37, 19], [4, 4, 4]);
    chosen
        .prepare(&volume.view(), &[Filter::Linear.into()], &mut || {})
        .unwrap();
    assert!(chosen.name().contains("(GPU unusable: "), "{}", chosen.name());
}

#[test]
fn without_a_card_the_cpu_draws_and_says_why() {
    let mut chosen = Chosen::open(Accepted::Nothing, Render::default());
    assert_eq!(chosen.name(), format!("{} (no GPU)", Cpu::default().name()));
    assert_eq!(chosen.note(), chosen.name());
    let (volume, sampling) = (noise([8, 8, 8], [4, 4, 4]), Sampling::from(Filter::BSpline));
    let plane = plane(&volume, [0.0; 3], [0.0, 0.0, 1.0], 0.5, [16, 16]).unwrap();
    chosen.prepare(&volume.view(), &[sampling], &mut || {}).unwrap();
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
    let chosen = Chosen::new(Render {
        back_end: BackEnd::Auto,
        ..Render::default()
    });
    match chosen.gpu() {
        Some(gpu) => assert_ne!(gpu.card.info.device_type, wgpu::DeviceType::Cpu),
        None => assert!(chosen.name().ends_with(')'), "{}", chosen.name()),
    }
    let cpu = Chosen::new(Render {
        back_end: BackEnd::Cpu,
        ..Render::default()
    });
    assert_eq!(cpu.name(), Cpu::default().name());
}
