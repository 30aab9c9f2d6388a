/* SPDX-License-Identifier: Apache-2.0 */
/* The options of ztex render that are about light and perspective. */
#include "pick.h"
#include "render.h"

#include <math.h>
#include <string.h>

#define SHADOW_IN_SPACE 0.3

static int read_vector(const cmd_args *args, const char *name, double out[3]) {
    const char *text = cmd_text(args, name);
    if (text && pick_numbers(text, out, 3, NULL))
        return cmd_usage(args, "--%s '%s': three numbers X,Y,Z are wanted", name, text);
    return CMD_OK;
}

static int read_pose(const cmd_args *args, render_space *space) {
    static const char *const names[] = {"eye", "target", "up"};
    double *const vectors[] = {space->pose.eye, space->pose.target, space->pose.up};
    for (int i = 0; i < 3; i++) {
        int status = read_vector(args, names[i], vectors[i]);
        if (status != CMD_OK)
            return status;
        space->posed |= cmd_given(args, names[i]) ? CAMERA_EYE << i : 0;
    }
    space->pose.fov = cmd_real(args, "fov");
    space->posed |= cmd_given(args, "fov") ? CAMERA_FOV : 0;
    return CMD_OK;
}

/* How the texture fills its square: its prism, or the shape of its image. */
static void measure_ground(const zt_file *file, uint32_t texture, const zt_image_info *image, render_space *space) {
    zt_umbrella_info info;
    space->cells_x = 1;
    space->aspect = (double)image->height / image->width;
    if (zt_get_umbrellas(file, texture, &info) != ZT_OK)
        return;
    space->cells_x = info.grid_x;
    space->aspect = (double)info.grid_y / info.grid_x;
    space->height = (double)info.prism_height;
}

int render_space_read(const cmd_args *args, const zt_file *file, uint32_t texture, const zt_image_info *image,
                      render_space *space) {
    static const char *const own[] = {"eye", "target", "up", "fov", "ambient"};
    int in_space = cmd_given(args, "3d") > 0;
    for (size_t i = 0; !in_space && i < sizeof own / sizeof own[0]; i++)
        if (cmd_given(args, own[i]))
            return cmd_usage(args, "--%s goes with --3d", own[i]);
    measure_ground(file, texture, image, space);
    space->ambient = (float)cmd_real(args, "ambient");
    if (!(space->ambient >= 0 && space->ambient <= 1))
        return cmd_usage(args, "--ambient is from 0 to 1");
    return read_pose(args, space);
}

int render_light_read(const cmd_args *args, zt_sampler_options *how, render_space *space) {
    double *light = space->light;
    int status = read_vector(args, "light", light);
    if (status != CMD_OK)
        return status;
    how->light_x = light[0];
    how->light_y = light[1];
    how->shadow = cmd_given(args, "shadow") || !cmd_given(args, "3d") ? cmd_real(args, "shadow") : SHADOW_IN_SPACE;
    if (!(how->shadow >= 0 && how->shadow <= 1))
        return cmd_usage(args, "--shadow is from 0, none, to 1, black");
    double length = sqrt(light[0] * light[0] + light[1] * light[1] + light[2] * light[2]);
    if (!(light[2] > 0))
        return cmd_usage(args, "--light: the light is above the ground: its Z is more than 0");
    for (int c = 0; c < 3; c++)
        light[c] /= length;
    return CMD_OK;
}
