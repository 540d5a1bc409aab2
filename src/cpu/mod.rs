pub mod narrow_phase;
