//! What went wrong in one candidate's simulation: a bitmask whose every bit names its remedy.

use bytemuck::{Pod, Zeroable};

/// Bits set while a candidate is simulated; 0 is a clean run.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Status(pub u32);

/// What can go wrong.
#[derive(Clone, Copy, Debug)]
pub struct Fault {
    /// Set where it did.
    pub bit: Status,
    /// For tables.
    pub name: &'static str,
    /// What the user can do about it.
    pub remedy: &'static str,
}

impl Status {
    /// More overlapping hull pairs than `Capacities::hull_pairs`.
    pub const HULL_PAIRS: Self = Self(1);
    /// More contact points than `Capacities::contacts`.
    pub const CONTACTS: Self = Self(2);
    /// A pose or velocity became NaN or infinite.
    pub const NOT_FINITE: Self = Self(4);
    /// Not a fault: others were better, and it was not simulated to its end (`CemSettings::rounds`).
    pub const PASSED_OVER: Self = Self(8);

    /// Every fault, for reports.
    pub const FAULTS: [Fault; 3] = [
        Fault {
            bit: Self::HULL_PAIRS,
            name: "hull pairs over capacity",
            remedy: "move apart what overlaps, or give its objects fewer convex parts",
        },
        Fault {
            bit: Self::CONTACTS,
            name: "contacts over capacity",
            remedy: "move apart what overlaps, or give its objects fewer convex parts",
        },
        Fault {
            bit: Self::NOT_FINITE,
            name: "not finite",
            remedy: "look for an object whose mass or size is out of proportion to the others'",
        },
    ];

    /// Sets the bits of `other`.
    pub fn insert(&mut self, other: Self) {
        self.0 |= other.0;
    }

    /// True if any bit of `other` is set.
    pub fn intersects(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }

    /// True if the result is whole: energies of other candidates are +∞ and never win.
    pub fn is_usable(self) -> bool {
        self == Self::default()
    }
}
