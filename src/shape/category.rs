//! What the free-text category says: how many convex parts an object may have, and how heavy it is.

/// At most how many parts most objects have.
pub(super) const USUAL_BUDGET: usize = 16;
/// Near-convex furniture: at most eight parts (the paper's budget).
const FURNITURE: [&str; 9] = ["box", "tray", "cabinet", "shelf", "table", "desk", "chair", "sofa", "bed"];
/// Organic shapes: at most 32 parts.
const ORGANIC: [&str; 6] = ["plant", "vase", "flower", "tree", "curtain", "leaf"];

/// The paper's mass classes with words of our own, range in kg, and the part volumes (m³) at its two ends.
const MASSES: [(&[&str], [f32; 2], [f32; 2]); 3] = [
    (
        &[
            "sofa",
            "couch",
            "desk",
            "bed",
            "cabinet",
            "wardrobe",
            "table",
            "shelf",
            "bookcase",
            "dresser",
            "sideboard",
            "nightstand",
            "commode",
            "cupboard",
            "counter",
            "fridge",
            "refrigerator",
            "oven",
            "stove",
            "dishwasher",
            "washer",
            "piano",
            "bathtub",
            "radiator",
            "fireplace",
        ],
        [60.0, 200.0],
        [0.02, 0.8],
    ),
    (
        &[
            "chair",
            "armchair",
            "stool",
            "ottoman",
            "pouf",
            "lamp",
            "tv",
            "television",
            "monitor",
            "screen",
            "fan",
            "bench",
            "plant",
            "tree",
            "speaker",
            "printer",
            "microwave",
            "computer",
            "whiteboard",
            "board",
            "curtain",
            "mirror",
            "bin",
            "dustbin",
            "basket",
            "suitcase",
            "guitar",
        ],
        [3.0, 7.0],
        [0.002, 0.2],
    ),
    (
        &[
            "cup",
            "mug",
            "glass",
            "bowl",
            "plate",
            "bottle",
            "can",
            "jar",
            "book",
            "vase",
            "remote",
            "phone",
            "tablet",
            "toy",
            "fruit",
            "tray",
            "box",
            "clock",
            "frame",
            "picture",
            "newspaper",
            "magazine",
            "laptop",
            "keyboard",
            "mouse",
            "teapot",
            "kettle",
            "pillow",
            "cushion",
            "flower",
            "game",
            "player",
            "toaster",
            "pot",
            "pan",
            "candle",
            "shoe",
            "hat",
            "bag",
            "ball",
            "pen",
        ],
        [2.5, 4.0],
        [0.0001, 0.05],
    ),
];

/// What has no class belongs to the one that its part volume (m³) is beyond, the heaviest first. By a density it would
/// be lighter by far than what has one, and engines do not bring ten things of 2.5 kg to rest in a tote of half a
/// kilogram.
const BY_VOLUME: [f32; 2] = [0.1, 0.01];

/// At most how many convex parts an object of this category gets.
pub fn part_budget(category: &str) -> usize {
    // The head noun of an English compound comes last: a "plant table" is a table.
    words(category)
        .rev()
        .find_map(|w| {
            if FURNITURE.iter().any(|f| matches(&w, f)) {
                Some(8)
            } else if ORGANIC.iter().any(|o| matches(&w, o)) {
                Some(32)
            } else {
                None
            }
        })
        .unwrap_or(USUAL_BUDGET)
}

/// Mass in kg of an object whose parts have this volume (m³): within the range of its category's class, logarithmic in
/// the volume (the paper asks a VLM for class and value; we have none).
pub fn typical_mass(category: &str, volume: f32) -> f32 {
    let named = |word: &str| MASSES.iter().position(|(names, ..)| names.iter().any(|name| matches(word, name)));
    let by_volume = || BY_VOLUME.iter().position(|from| volume > *from).unwrap_or(MASSES.len() - 1);
    let class = words(category).rev().find_map(|word| named(&word)).unwrap_or_else(by_volume);
    let (_, [light, heavy], [small, large]) = MASSES[class];
    let share = ((volume.max(1e-9) / small).ln() / (large / small).ln()).clamp(0.0, 1.0);
    light * (heavy / light).powf(share)
}

fn words(category: &str) -> impl DoubleEndedIterator<Item = String> {
    category.split(|c: char| !c.is_alphanumeric()).filter(|w| !w.is_empty()).map(str::to_lowercase)
}

/// Whether `word` is `name`, its plural, or a compound that ends in it ("armchair", but not "tablet" for "table").
fn matches(word: &str, name: &str) -> bool {
    // "shelves" and "leaves" have lost their f.
    let singular = match word.strip_suffix("ves") {
        Some(stem) => format!("{stem}f"),
        None => word.strip_suffix('s').unwrap_or(word).to_owned(),
    };
    [word, &singular, word.strip_suffix("es").unwrap_or(word)]
        .iter()
        .any(|w| *w == name || (name.len() > 3 && w.ends_with(name)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn budgets_follow_the_head_noun() {
        for (category, budget) in [
            ("coffee table", 8),
            ("office chair", 8),
            ("Bookshelves", 8),
            ("Armchair", 8),
            ("bed", 8),
            ("boxes", 8),
            ("potted plant", 32),
            ("vase", 32),
            ("plant table", 8),
            ("tablet", 16),
            ("mug", 16),
            ("", 16),
        ] {
            assert_eq!(part_budget(category), budget, "{category}");
        }
    }

    #[test]
    fn mass_stays_in_its_class_and_grows_with_volume() {
        for (category, low, high) in [("sofa", 60.0, 200.0), ("desk lamp", 3.0, 7.0), ("mug", 2.5, 4.0)] {
            let masses = [1e-6, 1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0].map(|v| typical_mass(category, v));
            assert!(masses.iter().all(|m| (low..=high * 1.0001).contains(m)), "{category}: {masses:?}");
            assert!(masses.is_sorted() && masses[0] < masses[6], "{category}: {masses:?}");
        }
    }

    #[test]
    fn what_has_no_class_weighs_what_others_of_its_size_do() {
        for (volume, like) in [(0.0, "mug"), (0.002, "mug"), (0.02, "lamp"), (0.2, "sofa")] {
            assert_eq!(typical_mass("gadget", volume), typical_mass(like, volume), "{volume} m³");
        }
    }
}
