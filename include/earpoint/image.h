#pragma once

/// earpoint::Image, 8 bits per channel, and earpoint::Box, a rectangle in one.
#include <earpoint/core/image.h>
