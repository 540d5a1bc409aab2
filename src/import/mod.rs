//! Foreign formats, turned into documents of our own. Conversions of axes, units and names happen here and only here.

pub mod rest3d;
