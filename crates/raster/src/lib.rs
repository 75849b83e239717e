//! The projection and Z-buffer pipeline.
