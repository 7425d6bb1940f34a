#pragma once
#define FIRMWARE_VERSION "1.4.0"
