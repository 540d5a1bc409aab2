//! Kernel `sample`: known answers of Philox, and the shape of the normals.

#![allow(missing_docs)]

use rest3d_gpu::cpu::sample::{normals, philox, sample, sample_candidate};
use rest3d_gpu::world::{CemSettings, Distribution, Stream};

/// Known answers published with Random123 (`philox4x32 10`).
#[test]
fn philox_gives_the_published_answers() {
    assert_eq!(philox([0; 4], [0; 2]), [0x6627_e8d5, 0xe169_c58d, 0xbc57_ac4c, 0x9b00_dbd8]);
    assert_eq!(philox([u32::MAX; 4], [u32::MAX; 2]), [0x408f_276d, 0x41c8_3b0e, 0xa20b_c7c6, 0x6d54_51fd]);
    assert_eq!(
        philox([0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344], [0xa409_3822, 0x299f_31d0]),
        [0xd16c_fe09, 0x94fd_cceb, 0x5001_e420, 0x2412_6ea1]
    );
}

#[test]
fn extreme_words_give_finite_normals() {
    for a in [0, 1, u32::MAX] {
        for b in [0, 1 << 31, u32::MAX] {
            for z in normals([a, b, b, a]) {
                assert!(z.is_finite() && z.abs() < 5.8, "{a} {b}: {z}");
            }
        }
    }
}

#[test]
fn normals_are_standard_and_uncorrelated() {
    const DIMENSIONS: usize = 12;
    const COUNT: usize = 20_000;
    let stream = Stream { seed: 7, stage: 3 };
    let (mean, std) = ([0.0; DIMENSIONS], [1.0; DIMENSIONS]);
    let mut rows = vec![[0.0_f32; DIMENSIONS]; COUNT];
    for (candidate, row) in rows.iter_mut().enumerate() {
        sample(&mean, &std, stream, 1, candidate as u32, row);
    }
    let average = |f: &dyn Fn(&[f32; DIMENSIONS]) -> f64| rows.iter().map(f).sum::<f64>() / COUNT as f64;
    // Standard errors are 1/√20000 = 0.007 (mean, correlation) and √2/√20000 = 0.010 (variance); 78 numbers are looked
    // at, so four and a half of them are allowed.
    for d in 0..DIMENSIONS {
        let m = average(&|row| row[d].into());
        let v = average(&|row| f64::from(row[d]).powi(2));
        assert!(m.abs() < 0.032 && (v - 1.0).abs() < 0.045, "dimension {d}: mean {m}, variance {v}");
        for e in 0..d {
            let c = average(&|row| f64::from(row[d]) * f64::from(row[e]));
            assert!(c.abs() < 0.032, "dimensions {d} and {e} are correlated: {c}");
        }
    }
    // 4.55 % of a normal lie beyond two deviations; standard error 0.0004 over all dimensions.
    let beyond = average(&|row| row.iter().filter(|z| z.abs() > 2.0).count() as f64 / DIMENSIONS as f64);
    assert!((beyond - 0.0455).abs() < 0.002, "{beyond}");
}

#[test]
fn every_part_of_the_counter_and_the_key_matters() {
    let draw = |seed: u64, stage, iteration, candidate| {
        let mut row = [0.0; 7];
        sample(&[0.0; 7], &[1.0; 7], Stream { seed, stage }, iteration, candidate, &mut row);
        row
    };
    let first = draw(1, 0, 0, 0);
    assert_eq!(first, draw(1, 0, 0, 0));
    for other in [draw(2, 0, 0, 0), draw(1 | 1 << 32, 0, 0, 0), draw(1, 1, 0, 0), draw(1, 0, 1, 0), draw(1, 0, 0, 1)] {
        assert_ne!(first, other);
    }
}

#[test]
fn more_dimensions_do_not_change_the_first_ones() {
    let stream = Stream { seed: 11, stage: 0 };
    let (mut short, mut long) = ([0.0; 6], [0.0; 18]);
    sample(&[0.5; 6], &[0.1; 6], stream, 4, 9, &mut short);
    sample(&[0.5; 18], &[0.1; 18], stream, 4, 9, &mut long);
    assert_eq!(short, long[..6]);
}

#[test]
fn antithetic_candidates_mirror_each_other_about_the_mean() {
    let stream = Stream { seed: 12, stage: 1 };
    let distribution = Distribution { mean: vec![0.5; 6], std: vec![0.1, 0.2, 0.3, 0.4, 0.5, 0.6] };
    let draw = |antithetic, sample_mean, candidate| {
        let cem = CemSettings { antithetic, sample_mean, ..CemSettings::default() };
        let mut row = [0.0; 6];
        sample_candidate(&cem, &distribution, (stream, 2), candidate, &mut row);
        row
    };
    for pair in 0..50 {
        let [one, other] = [2 * pair, 2 * pair + 1].map(|candidate| draw(true, false, candidate));
        // The first of a pair is drawn as without the option.
        assert_eq!(one, draw(false, false, 2 * pair));
        assert!(one.iter().zip(other).all(|(a, b)| (a + b - 1.0).abs() < 1e-6 && *a != b), "{one:?} {other:?}");
    }
    assert_eq!(draw(true, true, 0), [0.5; 6]);
    assert_eq!(draw(true, true, 1), draw(true, false, 1));
}
