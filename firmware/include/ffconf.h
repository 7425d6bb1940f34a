#pragma once
// Configuration of FatFs R0.16 (elm-chan.org/fsw/ff/doc/config.html), for 2 KB of RAM. FatFs's
// sources are in firmware/foreign/fatfs, as they were released.
#define FFCONF_DEF 80386

#define FF_FS_READONLY 0
#define FF_FS_MINIMIZE 0  // f_truncate is needed
#define FF_USE_EXPAND 1   // one contiguous piece
#define FF_USE_FIND 0
#define FF_USE_MKFS 0
#define FF_USE_FASTSEEK 0
#define FF_USE_CHMOD 0
#define FF_USE_LABEL 0
#define FF_USE_FORWARD 0
#define FF_USE_STRFUNC 0

#define FF_CODE_PAGE 932  // the only kind of code page whose table of capitals is not copied to RAM
#define FF_USE_LFN 0
#define FF_FS_RPATH 0

#define FF_VOLUMES 1
#define FF_STR_VOLUME_ID 0
#define FF_MULTI_PARTITION 0
#define FF_MIN_SS 512
#define FF_MAX_SS 512
#define FF_LBA64 0
#define FF_USE_TRIM 0

#define FF_FS_TINY 1  // one sector in memory for everything
#define FF_FS_EXFAT 0
#define FF_FS_NORTC 1  // no clock: every file is from the firmware's year
#define FF_NORTC_MON 1
#define FF_NORTC_MDAY 1
#define FF_NORTC_YEAR 2026
#define FF_FS_CRTIME 0
#define FF_FS_NOFSINFO 0
#define FF_FS_LOCK 0
#define FF_FS_REENTRANT 0
