// SPDX-License-Identifier: Apache-2.0
// The smallest program that uses libzt, as its users write it: header and library must agree.

#include <stdio.h>
#include <string.h>
#include <zt/zt.h>

int main(void) {
    char header[32];
    snprintf(header, sizeof header, "%d.%d.%d", ZT_VERSION_MAJOR, ZT_VERSION_MINOR, ZT_VERSION_PATCH);

    const char *library = zt_version_string();
    if (strcmp(header, library) != 0) {
        fprintf(stderr, "header %s, library %s\n", header, library);
        return 1;
    }
    printf("libzt %s\n", library);
    return 0;
}
