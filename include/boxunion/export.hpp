#pragma once

/// Marks what a shared library offers to programs; all else in it is hidden.
#define BOXUNION_API __attribute__((visibility("default")))
