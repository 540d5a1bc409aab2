//! What bears an object and how, with the names in files.

/// What a support tree stands on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Root {
    /// The plane y = 0.
    Ground,
    /// Any wall.
    Wall,
    /// The ceiling.
    Ceiling,
    /// On the ground and against a wall.
    GroundWall,
}

impl Root {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Ground, Self::Wall, Self::Ceiling, Self::GroundWall];

    /// Its name in a `scene.json`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ground => "ground",
            Self::Wall => "wall",
            Self::Ceiling => "ceiling",
            Self::GroundWall => "ground-wall",
        }
    }

    /// The root of a name, ours or that of REST3D's released files.
    pub fn from_name(name: &str) -> Option<Self> {
        match name {
            "ground" | "floor" => Some(Self::Ground),
            "wall" => Some(Self::Wall),
            "ceiling" => Some(Self::Ceiling),
            "ground-wall" | "floor-wall" => Some(Self::GroundWall),
            _ => None,
        }
    }
}

/// What bears an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parent {
    /// A part of the room.
    Root(Root),
    /// Another object, as index into [`Scene::objects`](super::Scene::objects).
    Object(usize),
}

/// How an object is borne by its parent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Relation {
    /// Stands or lies on it.
    On,
    /// Stands or lies within it.
    Inside,
    /// Hangs from it.
    Hanging,
    /// Is fastened to it.
    Attached,
}

impl Relation {
    /// Its name in a `scene.json`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::On => "on",
            Self::Inside => "inside",
            Self::Hanging => "hanging",
            Self::Attached => "attached",
        }
    }

    /// The relation of a name, ours or that of REST3D's released files.
    pub fn from_name(name: &str) -> Option<Self> {
        match name {
            "on" => Some(Self::On),
            "inside" => Some(Self::Inside),
            "hanging" | "hang" => Some(Self::Hanging),
            "attached" | "attach" | "on-attach" => Some(Self::Attached),
            _ => None,
        }
    }
}
