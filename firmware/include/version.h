#pragma once
#define FIRMWARE_VERSION "1.2.0"
