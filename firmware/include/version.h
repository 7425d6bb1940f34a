#pragma once
#define FIRMWARE_VERSION "1.1.0"
