#pragma once

/// Marks the symbols that the shared library exports. All others are hidden.
#define BOXUNION_API __attribute__((visibility("default")))
