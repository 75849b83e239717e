//! The `csg` command line, also for a model of your own.
