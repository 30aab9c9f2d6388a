/* SPDX-License-Identifier: Apache-2.0 */
/* Files and folders of a command line as a list of files. */
#ifndef ZTEX_FILE_LIST_H
#define ZTEX_FILE_LIST_H

#include "command.h"

typedef struct file_list {
    char **paths;
    size_t count, capacity;
} file_list;

/* Appends the operands in their order; of a folder all *.ztex in it and below, sorted by bytes. Links to folders are
 * not followed. Prints messages. Returns a cmd_status. */
int file_list_read(const cmd_args *args, file_list *list);
void file_list_free(file_list *list);

#endif
