#pragma once

/// What a program that links Earpoint may call; all else is hidden in the shared library.
#define EARPOINT_API __attribute__((visibility("default")))
