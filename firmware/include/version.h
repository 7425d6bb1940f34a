#pragma once
#define FIRMWARE_VERSION "1.0.0"
