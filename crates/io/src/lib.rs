//! Files: meshes and scenes, in and out.
