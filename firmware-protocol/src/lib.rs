//! The wire between a motorlab board and its host.
#![no_std]
