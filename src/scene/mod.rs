//! The document: objects, poses and support tree of a `scene.json`, in metres, Y up, ground at y = 0.
