//! Physics tests as functions of a backend, so that every backend passes the same ones.
//!
//! A simulation starts at rest, so a test that needs motion lets things fall, slide or push one another apart first.
//! `physics_suite!` lists all bodies once, for whichever harness runs them. A test says what it measured on stderr
//! (`cargo test --test physics -- --nocapture`); `docs/physics.md` holds those numbers.

pub mod bad_starts;
pub mod closed_forms;
pub mod concave;
pub mod determinism;
pub mod free_motion;
pub mod landing;
pub mod stacks;

use crate::common::scenario::{Scenario, State, run};
use rest3d_gpu::world::{Backend, SimSettings, angle_between};

/// Default settings for so many steps.
pub fn settings(steps: u32) -> SimSettings {
    SimSettings { steps, ..Default::default() }
}

/// Every hull–hull algorithm of the backend must pass.
pub fn both(backend: &dyn Backend, steps: u32) -> impl Iterator<Item = SimSettings> {
    backend.narrow_phases().iter().map(move |&narrow_phase| SimSettings { narrow_phase, ..settings(steps) })
}

/// The same without losses.
pub fn undamped(settings: SimSettings) -> SimSettings {
    SimSettings { linear_damping: 0.0, angular_damping: 0.0, ..settings }
}

/// Says what a test measured.
pub fn measured(what: &str, value: impl std::fmt::Display, expected: impl std::fmt::Display) {
    eprintln!("{what}: {value} (expected {expected})");
}

/// How far a scenario has strayed from its start.
#[derive(Debug)]
pub struct Drift {
    /// Largest distance of any body from its start at the end, m.
    pub moved: f32,
    /// Largest angle of any body from its start at the end, rad.
    pub turned: f32,
    /// Fastest body in the steps looked at, m/s.
    pub speed: f32,
}

/// Simulates from the start; speeds count from step `from` on.
pub fn drift(backend: &dyn Backend, scenario: &Scenario, settings: &SimSettings, from: usize) -> Drift {
    let world = scenario.world();
    let states = run(backend, &world, settings);
    let last = &states[states.len() - 1];
    let pairs = || last.0.iter().zip(&world.start);
    Drift {
        moved: pairs().map(|(p, q)| p.translation.distance(q.translation)).fold(0.0, f32::max),
        turned: pairs().map(|(p, q)| angle_between(p.rotation, q.rotation)).fold(0.0, f32::max),
        speed: peak_speed(&states[from..]),
    }
}

/// Fastest body in any of the states, m/s.
pub fn peak_speed(states: &[State]) -> f32 {
    states.iter().flat_map(|(_, v)| v).map(|v| v.linear.length()).fold(0.0, f32::max)
}

/// Hands every body, by module, to a macro: `with! { (arguments); module: [body, …] … }`.
macro_rules! physics_suite {
    ($with:ident $arguments:tt) => {
        $crate::physics::$with! { $arguments;
            free_motion: [
                free_fall_follows_the_scheme,
                spin_is_damped,
                a_torque_free_body_keeps_its_angular_momentum,
                a_collision_in_mid_air_keeps_momentum,
                rods_that_meet_in_mid_air_keep_their_angular_momentum,
                overlapping_bodies_in_mid_air_push_apart_evenly,
                energy_never_grows,
                energy_of_rods_never_grows,
                energy_of_heaps_never_grows,
                energy_of_hard_falls_never_grows,
                stacks_with_light_bottoms_gain_little_energy,
            ]
            closed_forms: [
                friction_cone,
                what_slides_over_seams_is_not_stopped,
                what_slides_goes_straight_down,
                a_block_tips_at_its_aspect,
                an_overhang_tips_when_its_centre_passes_the_edge,
                a_turned_overhang_tips_there_too,
                a_foot_of_many_parts_tips_at_the_rim_of_a_round_table,
                a_lever_weighs_half_a_percent,
                a_ball_rolls,
                a_prism_rolls_over_its_edges,
                a_block_topples_like_a_pendulum,
            ]
            landing: [
                thin_things_come_to_lie_on_the_ground,
                thin_things_do_not_pass_through_boards,
                a_corner_within_the_outline_of_a_foot_bears,
                what_falls_past_an_edge_falls_freely,
                tilted_boxes_fall_past_each_other,
                spinning_boxes_pass_what_they_do_not_reach,
                large_boxes_do_not_sink_in,
            ]
            stacks: [
                ten_high_stacks_stand,
                small_and_crooked_towers_stand,
                uneven_loads_stand,
                high_piles_bear_from_the_start,
                round_stacks_stand,
                thin_rods_lie_still,
                crossed_blocks_stand,
                heavy_overhangs_stand,
                a_pyramid_stands,
                a_mass_ratio_of_a_hundred,
                a_book_leans_as_statics_say,
                a_table_on_thin_legs_bears_a_load,
                a_light_table_bears_several_heavy_things,
                houses_of_cards_stand,
                a_mug_rests_on_a_tray_on_a_table,
            ]
            bad_starts: [
                overlap_is_pushed_apart_gently,
                five_in_one_place_come_apart,
                what_is_swallowed_comes_out,
                what_is_swallowed_anywhere_comes_out,
                a_book_in_a_wall_comes_out,
                what_is_squeezed_to_the_ground_stays,
                what_is_jammed_stays_calm,
                what_a_slanted_board_touches_is_not_thrown,
                every_corner_of_a_round_top_bears,
                a_plate_inside_a_table_top_comes_out,
                touching_hulls_are_not_missed,
            ]
            concave: [
                a_bowl_holds_its_fruit,
                a_cone_stays_in_its_ring,
                a_shelf_holds_its_books,
                a_drawer_holds_its_things,
                what_is_snug_in_a_shelf_lies_still,
            ]
            determinism: [
                a_second_run_gives_the_same_bits,
                a_candidate_does_not_depend_on_the_others,
                a_candidate_does_not_depend_on_what_has_ended,
            ]
        }
    };
}

/// A `#[test]` of every body for one backend: `physics_suite!(make_tests (backend))`.
#[allow(unused_macros)]
macro_rules! make_tests {
    (($backend:expr); $($module:ident: [$($body:ident,)+])+) => {
        $(mod $module {
            $(#[test]
            fn $body() {
                $crate::physics::$module::$body(&$backend);
            })+
        })+
    };
}

/// All bodies by name, for a harness of its own: `physics_suite!(list_tests ())`.
#[allow(unused_macros)]
macro_rules! list_tests {
    ((); $($module:ident: [$($body:ident,)+])+) => {
        [$($((
            concat!("physics::", stringify!($module), "::", stringify!($body)),
            $crate::physics::$module::$body as fn(&dyn rest3d_gpu::world::Backend),
        ),)+)+]
    };
}

#[allow(unused_imports)]
pub(crate) use {list_tests, make_tests, physics_suite};
