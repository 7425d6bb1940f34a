#pragma once
#define FIRMWARE_VERSION "1.3.0"
