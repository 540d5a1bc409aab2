pub mod elites;
pub mod energy;
pub mod moments;
pub mod place;
pub mod sample;
pub mod search;
